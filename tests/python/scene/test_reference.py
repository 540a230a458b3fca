"""The page of keys has what the parts of a scene, the waveforms and the measures say of themselves."""

from __future__ import annotations

import re

import pytest

import plica
from extension import keys
from plica.measures.waveforms import STORED
from plica.scene.part import OneOf, Part

PAGE = keys.text()
ROWS = [
    [cell.strip() for cell in re.split(r"(?<!\\)\|", line)[1:-1]]
    for line in PAGE.splitlines()
    if line.startswith("| `")
]


def test_every_key_waveform_and_measure_has_a_meaning() -> None:
    assert len(ROWS) > 150
    for row in ROWS:
        assert len(row[-1]) > 4, row


@pytest.mark.parametrize(
    "part",
    [
        part
        for part in (*Part.__subclasses__(), *OneOf.__subclasses__())
        if part.__module__.startswith("plica.scene.")  # not the settings of other commands
    ],
    ids=lambda part: part.__name__,
)
def test_every_key_of_a_scene_is_in_its_reference(part: type[Part]) -> None:
    assert set(part.model_fields) <= {row[0].strip("`") for row in ROWS}


def test_every_waveform_of_a_run_has_a_unit_and_a_meaning(phonating: plica.Scene) -> None:
    rough = plica.Contact(multipliers=plica.Multipliers(), friction=0.3)
    tube = {"uniform": {"length": "15 cm", "area": "3 cm^2"}}
    without = phonating.replace({"contact": rough, "airflow.rise": "1 ms"})
    between = without.replace({"tract": tube, "trachea": tube})
    inertial = between.replace({"airflow.model": plica.ViscousSlit(inertance=True)})
    finite = inertial.replace({"strain": "finite"})
    names = [
        set(plica.build_simulation(scene).advance(0))
        for scene in (phonating, without, between, inertial, finite)
    ]
    assert names[3] == set(STORED) - {"nonlinear_loss", "force_evaluations"}
    assert names[4] == set(STORED) - {"strain_neglected"}
    assert names[3] - names[2] == {"air_inertial_power", "air_inertial_energy"}
    assert names[1] - names[0] == {"friction_loss", "subglottal_pressure"}
    of_tubes = {"supraglottal_pressure", "flow_below", "flow_above", "lip_flow", "supply_rise"}
    energies = {"supply_energy", "tube_loss", "radiated_energy", "tube_outflow_energy", "tube_energy"}
    assert names[2] - names[1] == of_tubes | energies
