"""What measures have in common stands in the catalogue: no code tells them apart by a list of their names."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import plica
from plica.measures.catalogue import CATALOGUE, names

_PACKAGE = Path(plica.__file__).parent
_ALLOWED = {
    "commands/output.py": "the measures of the short table, in its order",
    "commands/synonyms.py": "what is meant by other words",
    "measures/flow_pulse.py": "measures them",
    "measures/glottal.py": "measures them",
    "measures/perturbation.py": "measures them",
    "measures/run/cautions.py": "energies as waveforms",
    "measures/run/contact.py": "measures them",
    "measures/run/folds.py": "measures them",
    "measures/run/solver.py": "energies as waveforms",
    "measures/sides.py": "measures them",
    "measures/sound_quality.py": "measures them",
    "report/run/comparison.py": "a rise of pressure against both flows",
    "report/wording.py": "the measures of the headline, in its order",
    "uncertainty/sample.py": "energies as waveforms; an input, and what is zero in the limit",
    "video/measures/waveforms.py": "measures them",
}


def _lists() -> Iterator[tuple[str, int]]:
    """File and line of every tuple, list or set of two names of measures or more."""
    for path in sorted(_PACKAGE.rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, (ast.Tuple, ast.List, ast.Set)):
                told = [item.value for item in node.elts if isinstance(item, ast.Constant)]
                if sum(isinstance(name, str) and name in CATALOGUE for name in told) > 1:
                    yield path.relative_to(_PACKAGE).as_posix(), node.lineno


def test_lists_of_measures_stand_in_the_catalogue_or_where_they_are_measured() -> None:
    found = list(_lists())
    assert not [place for place in found if place[0] not in _ALLOWED]
    assert {path for path, _ in found} == set(_ALLOWED), "an exception that is none any more"


def test_what_recordings_have_says_what_tells_it_and_nothing_else_does() -> None:
    for entry in CATALOGUE.values():
        assert (entry.recorded_from != "") == (entry.source != "run"), entry.name
        assert entry.angle == (entry.unit == "rad"), entry.name
        assert not entry.perturbation or entry.group == "Perturbation", entry.name


def test_measures_of_one_signal_say_of_which() -> None:
    """It alone says which measures are absent where there is no such signal."""
    signals = {"Airflow": {"", "flow"}, "Sound": {"sound"}, "Electroglottogram": {"egg"}}
    for name, entry in CATALOGUE.items():
        assert entry.signal in signals.get(entry.group, {""}), name
        assert (entry.recorded_from == "signal") == (entry.signal != "" and entry.source != "run"), name


def test_measures_of_a_fold_and_comparisons_of_both_are_named_so() -> None:
    for side in ("left", "right"):
        assert names(side=side) == {name for name in CATALOGUE if side in name} - {"left_right_phase"}
    assert names(side="difference") == {"amplitude_asymmetry", "area_asymmetry", "left_right_phase"}
    assert names(side="ratio") == {"amplitude_ratio"}
