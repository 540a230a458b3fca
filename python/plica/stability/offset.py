"""Offset of phonation: the pressure at which a voice dies when the pressure falls, by time steps."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from plica import _engine
from plica.errors import InvalidInput
from plica.runs.build import build_simulation
from plica.runs.progress import Progress
from plica.runs.scene_mesh import scene_mesh
from plica.scene.conditions import Initial
from plica.scene.scene import Scene
from plica.units import quantity_within

__all__ = ["Fall", "Offset", "offset"]

Floats = NDArray[np.float64]

_WINDOW = 4.0  # periods, of which an amplitude is
_LOST = 0.1  # of the amplitude before the fall, below which the oscillation is lost
_LEAST = 1e-3  # of the mean area: below, there is no voice to lose
_SETTLING = 60.0  # periods before the fall
_FAR = 0.2  # of the offset: a spread that makes it doubtful
_LOWEST = 0.1  # of the pressure before the fall, where the fall ends
_KICK = 0.1  # m/s, of a scene without initial values


@dataclass(frozen=True)
class Fall:
    """A voice under a pressure that falls evenly."""

    rate: float
    """[Pa/s]"""
    pressure: float | None
    """[Pa] At which the oscillation's amplitude became less than a tenth; None if it did not."""
    pressures: Floats
    """(k) Pa, in the middle of windows of four periods."""
    amplitudes: Floats
    """(k) m^2, half of what the least area varies by within each."""


@dataclass(frozen=True)
class Offset:
    """The pressure at which an oscillation dies."""

    pressure: float | None
    """[Pa] Of an infinitely slow fall, by those of two rates; None where the oscillation was not lost."""
    spread: float | None
    """[Pa] By how much that differs from the slower fall's."""
    frequency: float | None
    """[Hz] Of the voice before the fall."""
    start: float
    """[Pa] Before the fall."""
    falls: tuple[Fall, ...]
    """The faster one first."""
    remarks: tuple[str, ...]


def offset(
    scene: Scene,
    frequency: float | str,
    start: float | str,
    *,
    duration: float | str = 4.0,
    mesh: _engine.TetMesh | None = None,
    shown: bool = False,
) -> Offset:
    """Lower the pressure of a voice until its oscillation is lost.

    The voice settles under the pressure `start`; from there it falls evenly, at two rates. It is lost when
    the amplitude of the least area, over four periods, is less than a tenth of what it was. As it takes time
    to die, it is lost at a pressure that is too low: a decay whose rate grows in proportion to the pressure
    that is missing is over after a fall by a multiple of the square root of the rate, so that of rates r and
    r / 4 the offset is 2 p(r / 4) - p(r).

    Parameters
    ----------
    scene : Scene
        With an airflow; full, symmetric or reduced. It begins as it says, or, without initial values, with an
        opening velocity of 0.1 m/s; a pressure's rise or course plays no part.
    frequency : float or str
        [Hz] Roughly that of the oscillation, such as at onset.
    start : float or str
        [Pa] Above onset.
    duration : float or str
        [s] Of the slower fall, from `start` to a tenth of it; the other takes a quarter of it.
    mesh : TetMesh, optional
        The scene's mesh, if it is already built.
    shown : bool
        Show a progress bar on standard error.

    Raises
    ------
    InvalidInput
        If an argument is out of range, or the scene has no pressure that could fall.
    SolveFailed
        If a step has no solution.
    """
    pressure = quantity_within("offset", "start", start, "Pa", 1e-2, 1e6)
    longest = quantity_within("offset", "duration", duration, "s", 1e-3, 1e3)
    hertz = quantity_within("offset", "frequency", frequency, "Hz", 1e-3, 1e9)
    if not hertz < 0.1 / scene.time.step:
        raise InvalidInput(
            f"offset: frequency = {hertz:g} Hz; must have ten steps of time.step = "
            f"{scene.time.step:g} s a period or more."
        )
    _require(scene)
    mesh = scene_mesh(scene) if mesh is None else mesh
    return _Lowered(scene, mesh, hertz, pressure, longest, shown).result()


def _require(scene: Scene) -> None:
    if scene.airflow is None:
        raise InvalidInput(f"{scene.source}: airflow is missing; must be there, for its pressure to fall.")
    if scene.trachea is not None and scene.trachea.supply.flow is not None:
        raise InvalidInput(
            f"{scene.source}: trachea.supply is a flow; must be a pressure, for it to fall. Use "
            "trachea.supply.pressure."
        )


class _Lowered:
    def __init__(
        self,
        scene: Scene,
        mesh: _engine.TetMesh,
        frequency: float,
        pressure: float,
        longest: float,
        shown: bool,
    ) -> None:
        step = scene.time.step
        self.mesh, self.pressure, self.step = mesh, pressure, step
        self.window = max(round(_WINDOW / (frequency * step)), 8)
        self.settling = self.window * round(_SETTLING / _WINDOW)
        self.falling = [
            self.window * max(round(part * longest / step / self.window), 8) for part in (0.25, 1.0)
        ]
        start = {} if scene.initial is not None else {"initial": Initial(opening_velocity=_KICK)}
        self.scene = scene.replace({"airflow.rise": 0.0, **start})
        self.bar = Progress(self.settling + sum(self.falling), 0, step, shown=shown)
        self.done = 0

    def result(self) -> Offset:
        try:
            return self._result()
        finally:
            self.bar.close()

    def _result(self) -> Offset:
        first = self._simulation(self.falling[0])
        areas = np.concatenate([self._window(first) for _ in range(self.settling // self.window)])
        last = areas[-2 * self.window :]
        voice = 0.5 * float(np.ptp(last))
        if not voice > _LEAST * float(last.mean()):
            remark = (
                f"At {self.pressure:.4g} Pa no voice came about within {len(areas) * self.step:.3g} s: there "
                "is none to lose. Begin higher, or with a larger initial.opening_velocity."
            )
            return Offset(None, None, None, self.pressure, (), (remark,))
        state = first.state()
        falls = []
        for steps in self.falling:
            simulation = first if steps == self.falling[0] else self._simulation(steps)
            simulation.restore(state)
            falls.append(self._fall(simulation, steps, voice))
        return self._of(tuple(falls), _frequency(last, self.step))

    def _simulation(self, steps: int) -> _engine.Simulation:
        """Which settles, then falls within so many steps."""
        begin, length = self.settling * self.step, steps * self.step
        course = {
            "time": [begin, begin + length],
            "pressure": [self.pressure, _LOWEST * self.pressure],
        }
        changes = {"airflow.course": course, "airflow.subglottal_pressure": self.pressure}
        return build_simulation(self.scene.replace(changes), self.mesh)

    def _window(self, simulation: _engine.Simulation) -> Floats:
        found = np.asarray(simulation.advance(self.window, ["minimum_area"])["minimum_area"])
        self.done += self.window
        self.bar.update(self.done)
        return found

    def _fall(self, simulation: _engine.Simulation, steps: int, voice: float) -> Fall:
        """Until it is lost for two windows."""
        rate = (1 - _LOWEST) * self.pressure / (steps * self.step)
        end = self.done + steps
        pressures, amplitudes = list[float](), list[float]()
        for k in range(steps // self.window):
            pressures.append(self.pressure - rate * (k + 0.5) * self.window * self.step)
            amplitudes.append(0.5 * float(np.ptp(self._window(simulation))))
            if len(amplitudes) > 1 and max(amplitudes[-2:]) < _LOST * voice:
                break
        self.done = end
        self.bar.update(self.done)
        found = np.array(pressures), np.array(amplitudes)
        return Fall(rate, _lost(*found, _LOST * voice), *found)

    def _of(self, falls: tuple[Fall, ...], frequency: float) -> Offset:
        fast, slow = (fall.pressure for fall in falls)
        if fast is None or slow is None:
            lowest = _LOWEST * self.pressure
            remark = f"The oscillation goes on to {lowest:.4g} Pa, where the fall ends. Begin lower."
            return Offset(None, None, frequency, self.pressure, falls, (remark,))
        pressure = 2 * slow - fast
        spread = abs(pressure - slow)
        remarks: tuple[str, ...] = ()
        if spread > _FAR * pressure:
            remarks = (
                f"Of falls at {falls[0].rate:.3g} and {falls[1].rate:.3g} Pa/s it is lost at {fast:.4g} and "
                f"{slow:.4g} Pa: too far apart to say more. Let it fall more slowly.",
            )
        return Offset(pressure, spread, frequency, self.pressure, falls, remarks)


def _lost(pressures: Floats, amplitudes: Floats, least: float) -> float | None:
    """The pressure from which on the amplitude is less, between two windows, by its logarithm."""
    above = np.flatnonzero(amplitudes >= least)
    last = int(above[-1]) if above.size else 0
    if last + 1 >= len(amplitudes):
        return None
    logs = np.log(np.maximum(amplitudes[last : last + 2], 1e-300) / least)
    share = float(np.clip(logs[0] / (logs[0] - logs[1]), 0.0, 1.0))
    return float(pressures[last] + share * (pressures[last + 1] - pressures[last]))


def _frequency(area: Floats, step: float) -> float:
    """[Hz] The strongest one, of a spectrum padded to a hundredth of its lines."""
    spectrum = np.abs(np.fft.rfft((area - area.mean()) * np.hanning(len(area)), 64 * len(area)))
    return float(np.argmax(spectrum)) / (64 * len(area) * step)
