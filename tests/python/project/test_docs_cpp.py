"""What the C++ reference has of the headers, as Doxygen reads them."""

from __future__ import annotations

import shutil
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import pytest
from sphinx.errors import ExtensionError

from extension import cpp

needs_doxygen = pytest.mark.skipif(
    shutil.which("doxygen") is None, reason="no doxygen: apt install doxygen; nothing else reads the headers"
)


def members(where: Path, name: str) -> dict[str, str]:
    """What is said of each member of a class."""
    found = {}
    for member in ElementTree.parse(where / "xml" / f"{name}.xml").iter("memberdef"):
        said = [*member.findall("briefdescription"), *member.findall("detaileddescription")]
        text = " ".join(" ".join("".join(part.itertext()).split()) for part in said)
        found[member.findtext("name", "")] = text.strip()
    return found


@needs_doxygen
def test_a_comment_behind_a_declaration_is_its_meaning(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(cpp, "XML", tmp_path / "made" / "xml")
    monkeypatch.setitem(cpp._SETTINGS, "OUTPUT_DIRECTORY", tmp_path / "made")
    cpp._read_headers()
    load = members(tmp_path / "made", "structplica_1_1Load")
    assert load["frequency"] == "Hz, >= 0."
    assert load["validate"] == "throws InvalidInput"
    options = members(tmp_path / "made", "structplica_1_1imaging_1_1FlowOptions")
    assert options["data_scale"].endswith("grey levels, or px with gradient_noise, [1e-3, 1e3]")
    gauge = members(tmp_path / "made", "classplica_1_1StrainGauge")
    assert gauge["at_points"].startswith("(4 m), of linear cells (m): |eps| at each point")
    assert gauge["beyond"] == "of the volume lies beyond a percentile"


def test_without_doxygen_one_sentence_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(shutil, "which", lambda _: None)
    with pytest.raises(
        ExtensionError, match=r"docs: doxygen is not installed; must be, .*apt install doxygen\.$"
    ):
        cpp._read_headers()
