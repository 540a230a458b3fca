"""The noise of the jet: its law, its density, and that it can be had again."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import signal

from plica.errors import InvalidInput
from plica.sound.aspiration import aspiration_flow, critical_reynolds_number, reynolds_number

_L = 14e-3
_SCENE = "[airflow]\nair_density = 1.2\n[airflow.model.viscous_slit]\nair_viscosity = 1.8e-5\n"
_NU = 1.8e-5 / 1.2


def noise(flow: np.ndarray, step: float = 20e-6, seed: int = 1, scene: str = _SCENE) -> np.ndarray:
    time = step * np.arange(1, flow.size + 1)
    return aspiration_flow(time, {"flow": flow}, scene, _L, seed)


def test_the_number_is_that_of_a_slits_width() -> None:
    """U / (nu L) = v w / nu, of the speed v = U / (L w)."""
    width, speed = 0.7e-3, 31.0
    assert reynolds_number(np.array([speed * width * _L]), _L, 1.2, 1.8e-5) == pytest.approx(
        speed * width / _NU
    )


def test_there_is_none_below_the_critical_number() -> None:
    critical = critical_reynolds_number * _NU * _L
    assert (noise(np.full(2000, 0.999 * critical)) == 0).all()
    assert (noise(np.full(2000, 1.001 * critical)) != 0).all()


@pytest.mark.parametrize("step", [5e-6, 20e-6, 50e-6])
def test_its_power_density_is_that_of_the_law_at_any_step(step: float) -> None:
    flow = np.full(int(4.0 / step), 4e-4)
    found = noise(flow, step)
    excess = (4e-4 / (_NU * _L)) ** 2 - 1200.0**2
    wanted = excess**2 * 2 * (4e-12) ** 2 / 12 / 44100
    frequency, density = signal.welch(found, 1 / step, nperseg=int(0.05 / step))
    # 150 windows: a standard error of 8 % a bin, 1 % over the 40 of the middle of the band.
    middle = (frequency > 800) & (frequency < 1500)
    assert density[middle].mean() == pytest.approx(wanted, rel=0.05)
    for edge in (300.0, 3000.0):
        near = np.abs(frequency - edge) < 25
        assert density[near].mean() == pytest.approx(0.5 * wanted, rel=0.35)
    assert density[(frequency > 20) & (frequency < 60)].mean() < 0.01 * wanted


def test_the_same_seed_gives_the_same_noise_and_another_another() -> None:
    flow = np.full(3000, 4e-4)
    assert (noise(flow, seed=3) == noise(flow, seed=3)).all()
    assert np.corrcoef(noise(flow, seed=3), noise(flow, seed=4))[0, 1] < 0.1


def test_a_run_that_goes_on_keeps_the_noise_of_its_beginning() -> None:
    assert noise(np.full(3000, 4e-4))[:1000] == pytest.approx(noise(np.full(1000, 4e-4)))


def test_of_a_flow_model_without_viscosity_the_airs_is_taken() -> None:
    flow = np.full(3000, 4e-4)
    plain = '[airflow]\nair_density = 1.2\nmodel = "bernoulli"\n'
    zero = _SCENE.replace("1.8e-5", "0.0")
    assert noise(flow, scene=plain) == pytest.approx(noise(flow))
    with pytest.raises(InvalidInput, match="air_viscosity = 0; must be > 0"):
        noise(flow, scene=zero)


@pytest.mark.parametrize(
    ("waveforms", "step", "length", "message"),
    [
        (["flow", "lip_flow"], 20e-6, _L, "aspiration with a tract; must be without"),
        (["flow"], 20e-6, None, "must have a glottis of known length"),
        (["flow"], 20e-6, 0.0, "must have a glottis of known length"),
        (["flow"], 20e-6, -_L, "must have a glottis of known length"),
        (["flow"], 20e-6, np.nan, "must have a glottis of known length"),
        (["flow"], 200e-6, _L, "time.step = 200 us; must be < 166.7 us"),
        (["probes"], 20e-6, _L, "has no airflow"),
    ],
)
def test_what_has_no_noise_is_refused(waveforms: list[str], step: float, length: float, message: str) -> None:
    time = step * np.arange(1, 101)
    with pytest.raises(InvalidInput, match=message):
        aspiration_flow(time, {name: np.ones(100) for name in waveforms}, _SCENE, length, 1)
