"""Steps that record what is asked for."""

import numpy as np
import pytest

import plica


@pytest.fixture(scope="module")
def simulation() -> "plica._engine.Simulation":
    soft = plica.Tissue(E="10 kPa", nu=0.4, viscosity="1 Pa s")
    scene = plica.Scene(
        plica.Larynx(larynx="thesis_coarse"),
        {"body": soft, "ligament": soft, "cover": soft},
        airflow=plica.Airflow(subglottal_pressure="0.8 kPa"),
        time=plica.Stepping(step="50 us", duration="1 ms"),
    )
    return plica.build_simulation(scene)


def test_only_the_named_waveforms_are_recorded_and_they_are_those_of_all(simulation) -> None:
    start = simulation.state()
    everything = simulation.advance(4)
    simulation.restore(start)
    some = simulation.advance(4, ["flow", "minimum_area"])
    assert list(some) == ["flow", "minimum_area"]
    assert len(everything) > 20
    for name, values in some.items():
        assert values.shape == (4,)
        assert np.all(values == everything[name])
        assert np.all(values > 0)


def test_no_names_record_nothing(simulation) -> None:
    before = simulation.step_count
    assert simulation.advance(2, []) == {}
    assert simulation.step_count == before + 2


def test_a_waveform_that_the_scene_lacks_is_refused(simulation) -> None:
    with pytest.raises(plica.InvalidInput, match='"contact_rows" is a waveform of airflow'):
        simulation.advance(1, ["contact_rows"])
    with pytest.raises(plica.InvalidInput, match='"loudness" is no waveform'):
        simulation.advance(1, ["flow", "loudness"])
