"""Measures of a run's glottal flow as a source of sound, and of what it radiates."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from plica.errors import InvalidInput
from plica.measures.catalogue import CATALOGUE, OfSignal
from plica.measures.cycles import Cycles
from plica.measures.flow_pulse import declination_measures
from plica.measures.harmonics import cycle_means
from plica.measures.measure import Measure, absent, per_cycle, whole
from plica.measures.record import Array, Floats, time_step
from plica.measures.recorded import marks
from plica.measures.sound_quality import harmonic_differences, sound_measures
from plica.measures.stationary import fewest
from plica.measures.thresholds import cepstral_band
from plica.sound.far_field import FarField, equidistant, far_field, reflects
from plica.sound.voice import reference_pressure

__all__ = ["radiation_measures"]

_JUMP = 0.02  # of the flow's range, in the step in which contact stops it
_STEEPER = 3.0  # times the steps beside it
_SILENT = -60.0  # dB
_CORNER = 20e-6  # s, above which samples of a flow with a corner limit what tells cycles apart
_REFLECTING = "tract.end reflects a share of each wave and radiates nothing: let it be open for a sound"
_OF_A_CYCLE = 1.5  # times the share of a step in the period: shimmer of equal pulses with a corner


def radiation_measures(
    time: Floats, waveforms: Mapping[str, Array], scene_text: str, cycles: Cycles, supply: float | None
) -> list[Measure]:
    """All measures of the glottal flow as a source, and of the sound.

    Parameters
    ----------
    time : (k) s
    waveforms : mapping
        With ``flow``.
    scene_text : str
    cycles : Cycles
        Of the glottal area.
    supply : float or None
        Pa, subglottal pressure of the scene, where no waveform has it.
    """
    of_flow, even, flow = _source_measures(time, waveforms, cycles)
    try:
        field = far_field(time, waveforms, scene_text)
    except InvalidInput as error:
        reason = str(error).removeprefix("Sound: ").rstrip(".")
        return [*of_flow, *(absent(name, reason) for name in _names_of("sound"))]
    if not np.any(field.pressure):
        closed = "nothing moves at the lips: no sound leaves them"
        return [*of_flow, *(absent(name, closed) for name in _names_of("sound"))]
    doubts = [
        *_stopped_at_once(time, waveforms, cycles),
        *_coarse(field, time_step(time)),
        *([_REFLECTING] if reflects(scene_text) else []),
    ]
    of_sound = [
        _level(field, cycles, doubts),
        _efficiency(field, time, waveforms, cycles, supply, doubts),
        *sound_measures(
            field.time,
            field.pressure,
            cycles,
            band=field.band,
            cautions=doubts,
            marked=_marked(even, flow, cycles),
        ),
    ]
    return [
        *of_flow,
        *(
            _of(
                "the glottal flow" if item.name == "sound_jitter" else field.source,
                _sampled(item, time_step(even), cycles),
            )
            for item in of_sound
        ),
    ]


def _source_measures(
    time: Floats, waveforms: Mapping[str, Array], cycles: Cycles
) -> tuple[list[Measure], Floats, Floats]:
    """Measures of the glottal flow, also where nothing of it is heard; the flow at equidistant times."""
    flow = np.asarray(waveforms["flow"], dtype=float)
    wrong = np.count_nonzero(~np.isfinite(flow))
    if wrong or time.size < 2:
        why = f"the flow is no finite number in {wrong} steps" if wrong else f"the run has {time.size} steps"
        return [absent(name, why) for name in _names_of("flow")], time, flow
    jumps = _stopped_at_once(time, waveforms, cycles)
    even, flow = equidistant(time, flow)
    found = [
        *declination_measures(even, flow, cycles, jumps),
        *harmonic_differences("flow", even, flow, cycles, cautions=jumps),
    ]
    return found, even, flow


def _names_of(signal: OfSignal) -> list[str]:
    return [e.name for e in CATALOGUE.values() if e.signal == signal and e.source != "video"]


def _of(source: str, item: Measure) -> Measure:
    """The measure with what radiates, where it has a value."""
    return (
        item
        if item.value is None
        else replace(item, note="; ".join(filter(None, (f"of {source}", item.note))))
    )


def _sampled(item: Measure, step: float, cycles: Cycles) -> Measure:
    """The measure with what samples of equal pulses leave of it: of those of Liljencrants and Fant without a
    return phase, which end in a corner, at 98 to 313 Hz (test_sampled_corners)."""
    every = f"a corner of the flow, sampled every {1e6 * step:.3g} us, alone"
    notes = {
        "sound_harmonics_to_noise": f"no noise is in a run, only how cycles differ; {every} leaves "
        "20 to 30 dB",
        "sound_cepstral_peak_prominence": f"{every} lowers it by up to {6 if step < 60e-6 else 10} dB",
        "sound_shimmer": f"{every} makes up to {100 * _OF_A_CYCLE * step * cycles.frequency:.2g} %",
    }
    if step <= _CORNER or item.value is None or item.name not in notes:
        return item
    return replace(item, note=notes[item.name])


def _level(field: FarField, cycles: Cycles, doubts: list[str]) -> Measure:
    name, square = "sound_pressure_level", (field.pressure / reference_pressure) ** 2
    if not cycles.count:
        last = float(_decibels(square[cycles.extent(field.time)].mean()))
        why = f"over the last third of the record; {cycles.note}"
        if last < _SILENT:
            return absent(name, f"silent; {cycles.note}")
        return whole(name, last, cautions=[why, *doubts])
    return per_cycle(name, cycles, _decibels(cycle_means(field.time, square, cycles)), cautions=doubts)


def _decibels(ratio: Floats | float) -> Floats:
    with np.errstate(divide="ignore"):
        return np.asarray(10.0 * np.log10(ratio))


def _efficiency(
    field: FarField,
    time: Floats,
    waveforms: Mapping[str, Array],
    cycles: Cycles,
    supply: float | None,
    doubts: list[str],
) -> Measure:
    name = "glottal_efficiency"
    if not cycles.count:
        return absent(name, cycles.note)
    if "subglottal_pressure" in waveforms:
        pressure = _means("subglottal_pressure", time, waveforms, cycles)
    elif supply is not None:
        pressure = np.full(cycles.count, supply)
    else:
        return absent(name, "the subglottal pressure is not known")
    aerodynamic = pressure * _means("flow", time, waveforms, cycles)
    square = cycle_means(field.time, field.pressure**2, cycles)
    radiated = 4.0 * np.pi * field.distance**2 / (field.density * field.sound_speed) * square
    share = np.divide(radiated, aerodynamic, out=np.full(cycles.count, np.nan), where=aerodynamic > 0)
    return per_cycle(name, cycles, share, cautions=doubts)


def _marked(time: Floats, flow: Floats, cycles: Cycles) -> Cycles:
    """The cycles from mark to mark of the flow, where each has one (:mod:`plica.measures.recorded`), or all
    but that of a record's first flank: where the area passes its mean, another height is another period."""
    if not cycles.count:
        return cycles
    half = 0.5 / cycles.frequency
    found = marks(time, flow)
    found = found[(found > cycles.starts[0] - half) & (found < cycles.starts[-1] + half)]
    each = found.size >= max(cycles.count, fewest + 1) and bool(
        (np.abs(np.diff(found) - 2 * half) < half).all()
    )
    return replace(cycles, starts=found) if each else cycles


def _means(name: str, time: Floats, waveforms: Mapping[str, Array], cycles: Cycles) -> Floats:
    return cycle_means(time, np.asarray(waveforms[name], dtype=float), cycles)


def _coarse(field: FarField, step: float) -> list[str]:
    """A caution where the run's step leaves less of the sound than a cepstrum needs."""
    if field.band >= cepstral_band:
        return []
    return [
        f"time.step = {1e6 * step:.4g} us leaves the sound up to {field.band:.4g} Hz alone: use a "
        f"smaller one, {0.45e6 / cepstral_band:.4g} us or less"
    ]


def _stopped_at_once(time: Floats, waveforms: Mapping[str, Array], cycles: Cycles) -> list[str]:
    """A caution where contact stops or releases a flow that is not small, as with Bernoulli's model."""
    stopped = np.asarray(waveforms.get("flow_stopped", np.zeros(time.size)))
    part = cycles.extent(time)
    flow = np.asarray(waveforms["flow"], dtype=float)[part]
    if flow.size < 4:
        return []
    size, change = float(np.ptp(flow)), np.abs(np.diff(flow))
    beside = np.maximum(np.append(change[1:], 0.0), np.append(0.0, change[:-1]))
    jumps = change[(np.diff(stopped[part]) != 0) & (change > _STEEPER * beside)]
    if not jumps.size or float(jumps.max()) <= _JUMP * size:
        return []
    return [
        f"contact stops the flow at once, by {100 * float(jumps.max()) / size:.2g} % of its range in "
        "a step: what that radiates grows with the band and has no limit"
    ]
