"""Where the sources are, and which scenes are examples."""

from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
EXAMPLES = ROOT / "examples"
SCENES = sorted(path.name for path in EXAMPLES.glob("*.toml") if path.name != "identify.toml")
