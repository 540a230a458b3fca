"""Where the sources are, and which scenes are examples."""

import runpy
import shutil
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
EXAMPLES = ROOT / "examples"
SCENES = sorted(path.name for path in EXAMPLES.glob("*.toml") if path.name != "identify.toml")
_MAKERS = {"own_mesh.toml": "make_mesh.py", "own_folds.toml": "make_folds.py"}


def copied_example(name: str, folder: Path) -> Path:
    """An example scene in a copy of all of them, its mesh made if it has its own."""
    shutil.copytree(EXAMPLES, folder / "examples")
    if name in _MAKERS:
        runpy.run_path(str(folder / "examples" / _MAKERS[name]))
    return folder / "examples" / name
