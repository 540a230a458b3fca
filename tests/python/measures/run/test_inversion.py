"""Inverted cells: how many of how many, where and when, and what of a run is then no result."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import plica
from analytic_run import AnalyticRun, Phonation
from caution_scenes import LARYNX, Given
from plica import _engine
from plica.measures.caution import Caution
from plica.measures.run.inversion import inverted_cells

NO_MEANING = "Strain and stress of an inverted cell have no meaning, nor has the pressure of contact on it"


def layered(run: AnalyticRun) -> AnalyticRun:
    """With 200 cells in two layers."""
    mesh = replace(
        run.mesh,
        cells=np.tile(np.arange(4), (200, 1)),
        cell_layer=np.repeat([0, 1], 100),
        layer_names=("body", "cover"),
    )
    return replace(run, mesh=mesh)


def with_inverted(
    counts: dict[int, tuple[int, int]],
    neglected: float = 0.005,
    *,
    silent: bool = False,
    start: bool = False,
    finite: bool = False,
) -> Caution | None:
    """The caution of a run with so many cells of body and cover inverted in these steps."""
    run = layered((Phonation(rise_time=0.012, impulse=0.0) if start else Phonation()).run())
    by_layer = np.zeros((run.time.size, 2), dtype=int)
    for step, count in counts.items():
        by_layer[step] = count
    changed = {
        "inverted_by_layer": by_layer,
        "inverted_tissue": by_layer.sum(axis=1),
        "strain_neglected": np.full(run.time.size, neglected),
    }
    if silent:
        changed["minimum_area"] = np.full(run.time.size, 1e-5)
    if finite:
        changed["nonlinear_loss"] = np.zeros(run.time.size)
    return inverted_cells(replace(run, waveforms=run.waveforms | changed))


def test_a_run_without_inverted_cells_has_no_caution() -> None:
    assert with_inverted({}) is None
    run = Phonation().run()
    other = {name: values for name, values in run.waveforms.items() if not name.startswith("inverted")}
    assert inverted_cells(replace(run, waveforms=other)) is None


def test_of_tissue_at_finite_strain_the_mesh_is_the_reason() -> None:
    found, linear = with_inverted({800: (0, 52)}, finite=True), with_inverted({800: (0, 52)})
    assert found is not None
    assert linear is not None
    assert found.seen == linear.seen
    assert "the mesh is too coarse there" in found.advice
    assert "linear tissue" in linear.advice
    assert "linear tissue" not in found.advice


def test_few_and_many_inverted_cells_are_said_of_their_layers_and_time() -> None:
    few, many = with_inverted({800: (0, 52)}), with_inverted(dict.fromkeys(range(700, 750), (28, 120)))
    assert few is not None
    assert many is not None
    assert few.seen.startswith(
        "52 of 200 cells were inverted at 40.1 ms (52 in the cover), the most within the 11 cycles measured; "
    )
    assert many.seen.startswith(
        "148 of 200 cells were inverted at 35.1 ms (120 in the cover, 28 in the body), the most"
    )
    for caution, steps in ((few, 1), (many, 50)):
        share = float(caution.seen.split("measured; in ")[1].split(" %")[0])
        assert share == pytest.approx(100 * steps / 1100, rel=0.06)  # 11 cycles of 5 ms at 50 us; two digits
        assert caution.seen.endswith("% of that time some were.")
        assert caution.advice.startswith(f"{NO_MEANING}: use none of these.")
        assert "until none is inverted" in caution.advice
    one = with_inverted({800: (1, 0)})
    assert one is not None
    assert one.seen.startswith("1 of 200 cells was inverted at 40.1 ms (1 in the body)")


def test_beyond_half_the_gradient_s_error_nothing_is_a_result() -> None:
    # Where |grad u| < 1, an error of |grad u| / 2 < 50 %, no cell is inverted.
    below, above = (with_inverted({800: (0, 52)}, 0.5 * factor) for factor in (1 - 1e-9, 1 + 1e-9))
    assert below is not None
    assert above is not None
    assert "Less than 0.1 % of the tissue" in below.advice
    assert "motion and flow are those of linear tissue, which is off by 50 %" in below.advice
    assert "nothing of this run is a result" not in below.advice
    assert "nothing of this run is a result" in above.advice


def test_inverted_cells_of_the_start_leave_the_cycles_their_measures() -> None:
    caution = with_inverted({40: (3, 0)}, start=True)
    assert caution is not None
    assert caution.seen == (
        "3 of 200 cells were inverted at 2.05 ms (3 in the body), the most of the run; none in the "
        "6 cycles measured."
    )
    assert f"{NO_MEANING}, but no measure of the cycles is of one" in caution.advice
    assert "airflow.rise" in caution.advice
    assert "use none of these" not in caution.advice


def test_without_cycles_the_share_is_that_of_the_run() -> None:
    caution = with_inverted(dict.fromkeys(range(300), (0, 2)), silent=True)
    assert caution is not None
    assert (
        "the most within the run, in which no cycles were measured; in 25 % of that time some were."
        in caution.seen
    )
    assert "subglottal pressure" in caution.advice


def test_a_run_that_has_not_recorded_layers_says_the_rest() -> None:
    run = Phonation().run()
    waveforms = {name: values for name, values in run.waveforms.items() if name != "inverted_by_layer"}
    waveforms["inverted_tissue"] = np.where(np.arange(run.time.size) == 800, 1, 0)
    caution = inverted_cells(replace(run, waveforms=waveforms))
    assert caution is not None
    assert caution.seen.startswith("1 of 1 cells was inverted at 40.1 ms, the most within")


def test_the_engine_counts_the_inverted_cells_of_each_layer() -> None:
    scene = Given(LARYNX, "without airflow\nwithout contact\ninitial.opening_velocity = -40").build()
    simulation = plica.build_simulation(scene)
    mesh = plica.build_mesh(scene.mesh)
    cells, layer = np.asarray(mesh.cells), np.asarray(mesh.cell_layer)
    found = set()
    for _ in range(6):
        waves = simulation.advance(5)
        counts = waves["inverted_by_layer"]
        assert counts.shape == (5, 3)
        assert np.array_equal(counts.sum(axis=1), waves["inverted_tissue"])
        x = np.asarray(mesh.points) + np.asarray(simulation.displacement)
        inverted = np.asarray(_engine.signed_volumes(x, cells)) <= 0
        assert counts[-1].tolist() == [int(np.sum(inverted & (layer == k))) for k in range(3)]
        found |= set(np.flatnonzero(counts[-1]).tolist())
    assert len(found) > 1


def test_a_reduced_motion_keeps_the_counts_of_its_last_look_when_it_is_resumed() -> None:
    changes = "without airflow\nwithout contact\ninitial.opening_velocity = -8"
    scene = Given(LARYNX, changes, reduced=(20, 0)).build()
    whole, resumed = plica.build_simulation(scene), plica.build_simulation(scene)
    for _ in range(20):
        if whole.advance(4)["inverted_by_layer"][-1].any():
            break
    state = whole.state()
    resumed.restore(state)
    following = whole.advance(3)["inverted_by_layer"]  # no look before the fourth
    assert following.any()
    assert np.array_equal(resumed.advance(3)["inverted_by_layer"], following)
    for wrong in (
        state["watched"][:-1],
        np.append(state["watched"], 0.0),
        np.append(state["watched"][:-1], -1.0),
    ):
        with pytest.raises(
            plica.InvalidInput, match="inverted cells must be numbers >= 0 of this scene's 3 layers"
        ):
            resumed.restore({**state, "watched": wrong})
