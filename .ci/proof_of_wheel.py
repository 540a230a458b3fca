"""What a wheel must do where there is Python and nothing else; .ci/wheel runs it there."""

import contextlib
import io
import json
import os
import sys
from pathlib import Path

import plica
from plica.commands.main import main


def command(*words: str) -> str:
    """What `plica WORDS` prints; it must end well."""
    said = io.StringIO()
    with contextlib.redirect_stdout(said):
        code = main(list(words))
    if code != 0:
        sys.exit(f"plica {' '.join(words)}: code {code}\n{said.getvalue()}")
    return said.getvalue()


def must(holds: bool, what: str) -> None:
    if not holds:
        sys.exit(f"proof of the wheel: {what}")


for tool in ("sh", "cc", "gcc", "g++", "ld"):
    must(not Path("/usr/bin", tool).exists(), f"/usr/bin/{tool} is there; must not be")
info = plica.build_info()
must(info["absent"] == ["meshing"], f"the engine lacks {info['absent']}; must lack meshing alone")
must(Path(plica.__file__).is_relative_to("/site"), f"plica is {plica.__file__}; must be the wheel's")

os.chdir("/tmp")
command("examples", "scenes")
command("run", "scenes/first.toml", "-o", "first", "--quiet")
report = Path("first/report.html").read_text(encoding="utf-8")
must("<svg" in report or "<img" in report, "the report has no picture")
measures = json.loads(Path("first/measures.json").read_text(encoding="utf-8"))
must(measures["fundamental_frequency"]["value"] > 0, "the voice has no frequency")
command("view", "first")
verified = command("verify", "--quiet").splitlines()[-2:]
licences = command("info", "--licences")
must("Apache-2.0 WITH LLVM-exception" in licences, f"libc++ is not among the licences:\n{licences}")
print(f"Python {sys.version.split()[0]}, {info['compiler']}, kernels: {info['kernels']}")
print("\n".join(verified))
