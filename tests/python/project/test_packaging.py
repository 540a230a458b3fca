"""A package is labelled with the licence of what is in it."""

from __future__ import annotations

import subprocess
import tomllib
from email.parser import Parser
from importlib import metadata
from pathlib import Path

import pytest
from scikit_build_core import build
from scikit_build_core.settings.skbuild_read_settings import SettingsReader

import plica
from repository import ROOT


def test_the_installed_package_is_labelled_with_the_licence_of_its_build() -> None:
    label = metadata.metadata("plica")["License-Expression"]
    assert label == ("GPL-3.0-or-later" if plica.build_info()["gpl"] else "BSD-3-Clause")


@pytest.mark.parametrize(
    ("setting", "label"), [("", "BSD-3-Clause"), ("OFF", "BSD-3-Clause"), ("ON", "GPL-3.0-or-later")]
)
def test_a_wheel_with_parts_under_the_gpl_is_labelled_so(
    setting: str, label: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(ROOT)
    monkeypatch.setenv("PLICA_GPL", setting)
    made = build.prepare_metadata_for_build_wheel(str(tmp_path))
    text = Parser().parsestr((tmp_path / made / "METADATA").read_text(encoding="utf-8"))
    assert text["License-Expression"] == label
    assert text.get_all("License-File") == [
        "LICENSE",
        "python/bindings/licences.txt",
        "python/plica/viewer/vendor/licences.txt",
    ]


def test_parts_under_the_gpl_are_all_that_the_setting_changes(monkeypatch: pytest.MonkeyPatch) -> None:
    def defines(setting: str) -> dict[str, str]:
        monkeypatch.setenv("PLICA_GPL", setting)
        read = SettingsReader.from_file(ROOT / "pyproject.toml", state="wheel")
        return dict(read.settings.cmake.define)

    changed = {"PLICA_GPL": "ON", "PLICA_WHEEL_LICENCE": "GPL-3.0-or-later"}
    assert defines("OFF")["PLICA_PYTHON"] == "ON"
    assert defines("ON") == defines("OFF") | changed


@pytest.mark.parametrize(("gpl", "label"), [("ON", "BSD-3-Clause"), ("OFF", "GPL-3.0-or-later"), ("ON", "")])
def test_content_that_is_not_what_the_label_says_is_refused(gpl: str, label: str, tmp_path: Path) -> None:
    command = ["cmake", "-G", "Ninja", "-S", ROOT, "-B", tmp_path, "-DSKBUILD=2"]
    command += [f"-DPLICA_GPL={gpl}", f"-DPLICA_WHEEL_LICENCE={label}"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode != 0
    message = " ".join(done.stderr.split())
    assert f"plica: PLICA_GPL = {gpl} in a package labelled {label}; must be labelled " in message
    assert "Set PLICA_GPL to ON or OFF as an environment variable" in message


def test_what_a_distribution_leaves_out_lies_in_the_root() -> None:
    """An unanchored name would take folders of the package with it, such as plica/runs."""
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    left_out = settings["tool"]["scikit-build"]["sdist"]["exclude"]
    assert left_out
    assert all(pattern.startswith("/") for pattern in left_out)


def test_the_citation_names_this_version() -> None:
    cited = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    assert f"\nversion: {plica.__version__}\n" in cited
