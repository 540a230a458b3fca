"""The caution of large strain: what it sees, where and when, and what it advises."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

import plica
from analytic_run import Phonation
from caution_scenes import GIVEN
from plica import _engine
from plica.measures.caution import Caution
from plica.measures.run.cautions import cautions


def strained(left_out: float) -> list[Caution]:
    """Cautions of a run that leaves out so much in one step."""
    whole = Phonation().run()
    waveforms = {name: np.array(values) for name, values in whole.waveforms.items()}
    waveforms["strain_neglected"][700] = left_out
    waveforms["strain_999"][700] = 0.13
    return list(cautions(replace(whole, waveforms=waveforms)))


def test_large_strain_is_reported_in_one_sentence_once_a_tenth_of_it_is_wrong() -> None:
    assert strained(0.02 * (1 - 1e-9)) == []  # |grad u| = 0.2: |E - eps| is a tenth of it
    (caution,) = strained(0.02 * (1 + 1e-9))
    assert re.fullmatch(
        r"In the \d+ cycles measured, the strain of the tissue reached 13 %, and the error of the linear "
        r"tissue model reached 10 % at 35\.\d ms in layer \"body\" at \(.*\) mm\.",
        caution.seen,
    )


def test_a_layer_is_named_as_one_whatever_its_name() -> None:
    run = Phonation().run()
    large = {"strain_999": np.full(run.time.size, 0.5), "strain_neglected": np.full(run.time.size, 0.1)}
    mesh = replace(run.mesh, layer_names=("all",))
    (caution,) = cautions(replace(run, mesh=mesh, waveforms=run.waveforms | large))
    assert 'ms in layer "all" at (' in caution.seen
    assert 'or a stiffer layer "all".' in caution.advice


def test_a_strain_of_more_than_a_hundred_per_cent_is_a_plain_number() -> None:
    run = Phonation().run()
    large = {"strain_999": np.full(run.time.size, 1.04), "strain_neglected": np.full(run.time.size, 2.5)}
    (caution,) = (
        c for c in cautions(replace(run, waveforms=run.waveforms | large)) if c.name == "large_strain"
    )
    assert "the strain of the tissue reached 100 %," in caution.seen
    assert "reached 110 % at" in caution.seen


def started(left_out: float, within: float = 0.005, *, silent: bool = False) -> list[Caution]:
    """Cautions of a run that leaves out so much at its start and in the cycles; or without cycles."""
    whole = Phonation(rise_time=0.012, impulse=0.0).run()
    waveforms = {name: np.array(values) for name, values in whole.waveforms.items()}
    waveforms["strain_neglected"][:] = within
    waveforms["strain_neglected"][40] = left_out
    if silent:
        waveforms["minimum_area"][:] = 1e-5
    return list(cautions(replace(whole, waveforms=waveforms)))


def test_the_strain_of_the_start_is_no_caution_and_stands_beside_one() -> None:
    assert started(0.32) == []
    (caution,) = started(0.32, 0.03)
    assert "reached 12 % at" in caution.seen.split(";")[0]  # of the cycles
    assert "outside them it was 40 %, at 2.05 ms" in caution.seen
    assert "airflow.rise" in caution.advice


def test_without_cycles_all_of_a_run_is_judged() -> None:
    (caution,) = started(0.32, silent=True)
    assert caution.seen.startswith("In the whole run")
    assert "40 %" in caution.seen
    for setting in ("subglottal pressure", "stiffer", "airflow.rise"):
        assert setting in caution.advice
    assert "velocity" not in caution.advice


def test_the_advice_on_strain_is_of_what_strains() -> None:
    whole = Phonation(impulse=0.0).run()
    strain = {"strain_neglected": np.full(whole.time.size, 0.03)}
    rising = np.minimum(whole.time, 10e-3)
    (caution,) = cautions(
        replace(whole, waveforms=whole.waveforms | strain | {"subglottal_pressure": rising})
    )
    assert "subglottal pressure" in caution.advice
    assert "airflow.rise" not in caution.advice  # it has one
    with_air = {"minimum_area", "flow", "subglottal_pressure"}
    still = {name: values for name, values in whole.waveforms.items() if name not in with_air}
    (caution,) = cautions(replace(whole, waveforms=still | strain))
    assert "initial velocity" in caution.advice
    assert "pressure" not in caution.advice


def test_the_strain_of_the_engine_is_that_of_its_displacement() -> None:
    simulation = plica.build_simulation(GIVEN["large_strain"].build())
    for _ in range(4):
        waves = simulation.advance(10)
    mesh = plica.build_mesh(GIVEN["large_strain"].build().mesh)
    corners = np.asarray(mesh.cells)
    assert corners.shape[1] == 4
    x, u = np.asarray(mesh.points)[corners], np.asarray(simulation.displacement)[corners]
    edges, moves = x[:, 1:] - x[:, :1], u[:, 1:] - u[:, :1]
    gradient = np.swapaxes(np.linalg.solve(edges, moves), 1, 2)  # moves = edges gradient^T
    strain = np.linalg.norm(0.5 * (gradient + np.swapaxes(gradient, 1, 2)), 2, axis=(1, 2))
    left_out = 0.5 * np.linalg.norm(gradient, 2, axis=(1, 2)) ** 2
    volume = np.linalg.det(edges)

    def exceeded(values: np.ndarray) -> float:
        order = np.argsort(-values)
        return float(
            values[order][np.searchsorted(np.cumsum(volume[order]), 1e-3 * volume.sum(), side="right")]
        )

    assert waves["strain_largest"][-1] == pytest.approx(strain.max(), rel=1e-7)
    assert waves["strain_cell"][-1] == strain.argmax()
    assert waves["strain_999"][-1] == pytest.approx(exceeded(strain), rel=1e-7)
    assert waves["strain_neglected"][-1] == pytest.approx(exceeded(left_out), rel=1e-7)
    assert waves["inverted_tissue"][-1] == np.sum(
        _engine.signed_volumes(np.asarray(mesh.points) + np.asarray(simulation.displacement), corners) <= 0
    )
