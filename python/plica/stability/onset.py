"""Onset of phonation: the lowest pressure at which a small oscillation about the equilibrium grows."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from plica import _engine
from plica.errors import InvalidInput, SolveFailed
from plica.runs.flow_equilibrium import FlowEquilibrium
from plica.scene.scene import Scene
from plica.stability.small_motion import SmallMotion, Spectrum, damping_of
from plica.units import quantity_within

__all__ = ["Crossing", "Onset", "Participation", "growth", "onset"]

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]

_PRESSURES = 40  # of the range, before what is looked at more closely
_SHOWN = 6  # pairs that are followed into the results
_TOLERANCE = 1e-9  # of the pressure of onset
_KINKED = 1e-2  # of the flow: above, it has no tangent
_LOWEST, _HIGHEST = 1e-2, 1e6  # Pa


@dataclass(frozen=True)
class Participation:
    """A mode of the tissue without air in an oscillation."""

    mode: int
    """From 1, by rising frequency; 0: all that is left, static responses included."""
    frequency: float
    """[Hz] Of the mode without air; nan of what is left."""
    share: float
    """[-] Of the oscillation's elastic energy."""
    phase: float
    """[rad] Against the mode with the largest share."""


@dataclass(frozen=True)
class Crossing:
    """A pressure at which the least stable oscillation begins to grow, or ceases to."""

    pressure: float
    """[Pa]"""
    frequency: float
    """[Hz]"""
    grows_above: bool
    slope: float
    """[1/(s Pa)] Of its growth over the pressure."""


@dataclass(frozen=True)
class Onset:
    """What becomes of small oscillations as the subglottal pressure rises."""

    crossings: tuple[Crossing, ...]
    """By rising pressure; without any there is no onset in the range."""
    participation: tuple[Participation, ...]
    """At the onset, `first`."""
    equilibrium: FlowEquilibrium | None
    """At the onset."""
    pressure_error: float | None
    """[Pa] By how much the onset moves with half the modes: its error by truncation, if not less."""
    frequency_error: float | None
    """[Hz]"""
    pressure: Floats
    """(k) Pa"""
    pairs: Complex
    """(k, b) 1/s, eigenvalues of the pairs that grow most, each followed over pressures; nan where lost."""
    least_stable: Complex
    """(k) 1/s, that of the largest real part."""
    fastest: Floats
    """(k) 1/s, the largest real eigenvalue; above 0 the equilibrium is left without oscillation."""
    area: Floats
    """(k) m^2, least area of a section."""
    flow: Floats
    """(k) m^3/s"""
    end: str
    """Why pressures end before the range does; empty where they do not."""
    remarks: tuple[str, ...]
    """What to check before trusting it."""
    damping: str
    modes: int
    symmetry: str | None
    """Of the scene, which all oscillations have; None where all were looked at."""

    @property
    def first(self) -> Crossing | None:
        """The onset: the first crossing above which an oscillation grows, or None."""
        return next((one for one in self.crossings if one.grows_above), None)


def growth(
    scene: Scene,
    pressure: float | str,
    *,
    modes: int | None = None,
    zeta: float | None = None,
    loss_factor: float | None = None,
    mesh: _engine.TetMesh | None = None,
) -> Complex:
    """Eigenvalues s (k) 1/s of small oscillations exp(s t) under a pressure, the least stable first.

    Parameters are those of `onset`; raises SolveFailed where there is no equilibrium under this pressure, and
    where the equilibrium is left without oscillation (a real eigenvalue is positive): no tissue stays in it.
    """
    wanted = quantity_within("onset", "at", pressure, "Pa", _LOWEST, _HIGHEST)
    motion = SmallMotion(scene, modes, damping_of(zeta, loss_factor), mesh)
    found = motion.spectrum(wanted)
    if found.fastest > 0:
        raise SolveFailed(
            f"Equilibrium with the flow: at {wanted:g} Pa it is left without oscillation, growing by "
            f"{found.fastest:.4g} 1/s; must not be, for oscillations about it to mean anything. Take a lower "
            "pressure."
        )
    return found.pairs


def onset(
    scene: Scene,
    *,
    start: float | str | None = None,
    stop: float | str = 3000.0,
    modes: int | None = None,
    zeta: float | None = None,
    loss_factor: float | None = None,
    mesh: _engine.TetMesh | None = None,
    each: Callable[[float, float], None] | None = None,
) -> Onset:
    """Find where the equilibrium with the airflow loses its stability to an oscillation (a Hopf point).

    Parameters
    ----------
    scene : Scene
        With an airflow whose load acts on the surface at rest. Contact, initial values and the pressure's
        rise play no part; with a symmetry oscillations are symmetric.
    start, stop : float or str
        [Pa] Pressures that are looked at. Default: from a hundredth of `stop` to 3 kPa.
    modes : int, optional
        Number of modes, beside static responses to the pressures of the sections. Default: 50, or as many
        as the mesh has.
    zeta : float, optional
        Damping ratio of every mode, instead of the tissue's viscosity.
    loss_factor : float, optional
        Of a stiffness K (1 + i loss_factor), instead of the tissue's viscosity.
    mesh : TetMesh, optional
        The scene's mesh, if it is already built.
    each : callable, optional
        Called with each pressure (Pa) and the growth (1/s) found there, as a sign of progress.

    Returns
    -------
    Onset

    Raises
    ------
    InvalidInput
        If an argument is out of range, the scene has no airflow, no damping, or is overlapping at rest.
    SolveFailed
        If there is no equilibrium at all.
    """
    last = quantity_within("onset", "stop", stop, "Pa", _LOWEST, _HIGHEST)
    first = (
        0.01 * last if start is None else quantity_within("onset", "start", start, "Pa", _LOWEST, _HIGHEST)
    )
    if not first < last:
        raise InvalidInput(
            f"onset: start = {first:g} Pa; must be < stop = {last:g} Pa. Pressures rise from it."
        )
    motion = SmallMotion(scene, modes, damping_of(zeta, loss_factor), mesh)
    return _Search(motion, each).over(first, last)


class _Search:
    def __init__(self, motion: SmallMotion, each: Callable[[float, float], None] | None) -> None:
        self.motion = motion
        self.each = each
        self.spectra: dict[float, Spectrum] = {}
        self.end = ""

    def over(self, first: float, last: float) -> Onset:
        self._scan(first, last)
        self._look_closer()
        crossings = tuple(self._crossing(a, b) for a, b in self._changes())
        return self._result(crossings)

    def _at(self, pressure: float) -> Spectrum:
        if pressure in self.spectra:
            return self.spectra[pressure]
        found = self.motion.spectrum(pressure)
        self.spectra[pressure] = found
        if self.each:
            self.each(pressure, found.growth)
        return found

    def _scan(self, first: float, last: float) -> None:
        """Up to where the equilibrium ends."""
        for pressure in np.linspace(first, last, _PRESSURES):
            try:
                self._at(float(pressure))
            except SolveFailed as failure:
                self.end = str(failure)
                reached = self.motion.branch.reached
                if reached < first:
                    raise
                if reached not in self.spectra:
                    self._at(reached)
                return

    def _sorted(self) -> tuple[Floats, Floats]:
        """Pressures, and the growth of the least stable pair."""
        pressures = np.array(sorted(self.spectra))
        return pressures, np.array([self.spectra[p].growth for p in pressures])

    def _look_closer(self) -> None:
        """Halve the steps beside peaks below zero that may reach above it, and beside valleys above zero."""
        for _ in range(3):
            pressures, found = self._sorted()
            new = set()
            for k in range(1, len(pressures) - 1):
                left, here, right = found[k - 1 : k + 2]
                peak = here < 0 and here >= max(left, right)
                valley = here > 0 and here <= min(left, right)
                if (peak or valley) and abs(here) < max(abs(here - left), abs(here - right)):
                    new |= {0.5 * (pressures[k - 1] + pressures[k]), 0.5 * (pressures[k] + pressures[k + 1])}
            if not new:
                return
            for pressure in sorted(new):
                with suppress(SolveFailed):  # the equilibrium ends between two pressures: `end` says so
                    self._at(pressure)

    def _changes(self) -> list[tuple[float, float]]:
        pressures, found = self._sorted()
        places = np.flatnonzero((found[:-1] > 0) != (found[1:] > 0))
        return [(float(pressures[k]), float(pressures[k + 1])) for k in places]

    def _crossing(self, low: float, high: float) -> Crossing:
        """The least stable pair being asked for anew at each pressure."""
        grows = self.spectra[high].growth > 0
        pressure = _root(lambda p: self._at(p).growth, low, high)
        spectrum = self.spectra[pressure]
        near = 1e-3 * pressure
        try:
            slope = (self.motion.spectrum(pressure + near).growth - spectrum.growth) / near
        except SolveFailed:  # the equilibrium ends just there
            slope = (spectrum.growth - self.motion.spectrum(pressure - near).growth) / near
        return Crossing(pressure, spectrum.frequency, grows, slope)

    def _result(self, crossings: tuple[Crossing, ...]) -> Onset:
        first = next((one for one in crossings if one.grows_above), None)
        pressures, _ = self._sorted()
        spectra = [self.spectra[p] for p in pressures]
        errors: tuple[float | None, float | None] = (None, None)
        participation: tuple[Participation, ...] = ()
        rest = None
        if first is not None:
            errors = self._truncation(first)
            spectrum = self.motion.spectrum(first.pressure, vectors=True)
            participation = participating(self.motion, spectrum)
            rest = spectrum.equilibrium
        return Onset(
            crossings=crossings,
            participation=participation,
            equilibrium=rest,
            pressure_error=errors[0],
            frequency_error=errors[1],
            pressure=pressures,
            pairs=followed([one.pairs for one in spectra]),
            least_stable=np.array([one.pairs[0] if len(one.pairs) else np.nan for one in spectra]),
            fastest=np.array([one.fastest for one in spectra]),
            area=np.array([one.equilibrium.area.min() for one in spectra]),
            flow=np.array([one.equilibrium.flow for one in spectra]),
            end=self.end,
            remarks=self._remarks(first, pressures, spectra),
            damping=self.motion.damping.description,
            modes=self.motion.modes,
            symmetry=self.motion.scene.symmetry,
        )

    def _truncation(self, first: Crossing) -> tuple[float | None, float | None]:
        """By how much the crossing moves with half the modes."""
        fewer = self.motion.with_modes(max(self.motion.modes // 2, 1))
        known: dict[float, Spectrum] = {}

        def growth_at(pressure: float) -> float:
            known[pressure] = fewer.spectrum(pressure)
            return known[pressure].growth

        low = high = first.pressure
        sign = growth_at(low) > 0
        for part in (0.003, 0.01, 0.03, 0.1, 0.3):
            below = sign == (first.slope > 0)
            other = first.pressure * (1 - part if below else 1 + part)
            try:
                changes = (growth_at(other) > 0) != sign
            except SolveFailed:
                return None, None
            low, high = min(low, other), max(high, other)
            if changes:
                found = _root(growth_at, low, high)
                return abs(found - first.pressure), abs(known[found].frequency - first.frequency)
        return None, None

    def _remarks(self, first: Crossing | None, pressures: Floats, spectra: list[Spectrum]) -> tuple[str, ...]:
        found = []
        left = [p for p, one in zip(pressures, spectra, strict=True) if one.fastest > 0]
        if left:
            found.append(
                f"From {left[0]:.4g} Pa on the equilibrium is left without oscillation (a real eigenvalue is "
                "positive): what is found above is about a state that tissue does not stay in."
            )
        if spectra[0].growth > 0:
            found.append(
                f"An oscillation grows at the lowest pressure, {pressures[0]:.4g} Pa, already: onset is "
                "below. Begin lower."
            )
        upto = pressures <= (np.inf if first is None else first.pressure)
        kinked = [
            p
            for p, one, is_below in zip(pressures, spectra, upto, strict=True)
            if is_below and one.equilibrium.tangent.kink > _KINKED
        ]
        if kinked:
            found.append(
                f"At {len(kinked)} of {int(upto.sum())} pressures, from {kinked[0]:.4g} Pa on, the flow has "
                "a kink (two sections share the least area, or a jet leaves at a section): growth is that of "
                "the mean slope. Take another number of sections to see what it matters."
            )
        return tuple(found)


def _root(value: Callable[[float], float], low: float, high: float) -> float:
    """Where a value changes its sign between these (Brent's method): the last place it was asked at."""
    try:
        return float(brentq(value, low, high, xtol=_TOLERANCE * low, rtol=_TOLERANCE))
    except RuntimeError as error:
        raise SolveFailed(
            f"onset: growth changes its sign between {low:.6g} and {high:.6g} Pa; not found where: {error}"
        ) from None


def participating(motion: SmallMotion, spectrum: Spectrum, pair: int = 0) -> tuple[Participation, ...]:
    """The modes of most elastic energy in a pair's oscillation, those over 1 %, and what is left."""
    assert spectrum.vectors is not None
    vector = spectrum.vectors[:, pair]
    share = motion.squares * np.abs(vector) ** 2
    share = share / share.sum()
    order = [int(k) for k in np.argsort(-share[: motion.modes]) if share[k] > 0.01]
    largest = order[0] if order else 0
    rows = [
        Participation(
            k + 1,
            float(motion.frequencies[k]),
            float(share[k]),
            float(np.angle(vector[k] * np.conj(vector[largest]))),
        )
        for k in order
    ]
    rest = 1 - sum(row.share for row in rows)
    return (*rows, Participation(0, float("nan"), float(rest), 0.0))


def followed(spectra: list[Complex], count: int = _SHOWN) -> Complex:
    """Pairs (k, b) of successive spectra, each taken for what comes nearest to where it was heading.

    Of all pairs of the first spectrum those are kept that come nearest to growing anywhere, by their
    frequency there.
    """
    from scipy.optimize import linear_sum_assignment

    tracks = np.full((len(spectra), len(spectra[0])), np.nan + 0j)
    tracks[0] = spectra[0]
    for k in range(1, len(spectra)):
        heading = tracks[k - 1]
        if k > 1:
            ahead = 2 * tracks[k - 1] - tracks[k - 2]
            heading = np.where(np.isfinite(ahead), ahead, heading)
        there = np.flatnonzero(np.isfinite(heading))
        cost = np.abs(heading[there, None] - spectra[k][None, :])
        own, other = linear_sum_assignment(cost)
        tracks[k, there[own]] = spectra[k][other]
    if not tracks.shape[1]:
        return tracks
    best = np.nanmax(np.where(np.isfinite(tracks), tracks.real, -np.inf), axis=0)
    kept = np.argsort(-best, kind="stable")[:count]
    return tracks[:, kept[np.argsort(tracks[0, kept].imag, kind="stable")]]
