"""The page of a report: status, cautions, figures, tables and scene."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from plica.measures.caution import Caution
from plica.measures.run.run_data import MeasuredRun
from plica.measures.uncertainty import Uncertainty
from plica.report.drawing import Drawing
from plica.report.page import render
from plica.report.run.coronal import kymogram, pressure_map, trajectories
from plica.report.run.cycle import coronal_cycle, superior_cycle
from plica.report.run.energy import energy_balance, probe_motion, probe_spectrum
from plica.report.run.reading import Reading, read
from plica.report.run.sound import SoundReading, read_sound
from plica.report.run.tubes import air_at_the_glottis
from plica.report.run.waveforms import contact_forces, glottal_waveforms, whole_run
from plica.report.wording import headlines, number, numbered_after, tables
from plica.storage.files import write_text


def write_report(run: MeasuredRun, path: Path, uncertainty: Uncertainty | None = None) -> Path:
    """Write the report of a run as one self-contained HTML page.

    Parameters
    ----------
    run : MeasuredRun
        Finished, interrupted or failed; the page shows which.
    path : Path
        Path of the page, which is replaced as a whole. It links to the page of `plica view`, if that lies
        beside it.
    uncertainty : Uncertainty, optional
        The estimate of the numerical uncertainty that its measures have, for its levels and remarks.

    Returns
    -------
    Path
        The page.
    """
    reading = read(run)
    heard = read_sound(reading)
    measured, notes = tables(reading.measures), list[str]()
    given = run.cautions
    marks = {row.name: numbered_after(row.cautions, given, notes) for _, rows in measured for row in rows}
    text = render(
        "report/run/page.html.j2",
        title=path.resolve().parent.name or "run",
        banner=banner(reading),
        cautions=given,
        remark=remark(reading, given),
        view=path.with_name("view.html").is_file(),
        headlines=headlines(reading.measures) if voiced(reading) else [],
        tables=measured,
        marks=marks,
        notes=notes,
        uncertainty=uncertainty,
        source=next((item.bound.source for item in reading.measures.values() if item.bound), ""),
        sections=sections(reading, heard),
        player=None if heard is None else heard.player,
        scene=run.scene_text.strip(),
        versions=dict(run.versions),
    )
    return write_text(text, path)


def banner(reading: Reading) -> str:
    """A note if the run is not finished, else empty."""
    done, asked = reading.time.size, reading.run.steps_asked
    extent = f"{done} of {asked} steps" + (f", to {number(1e3 * float(reading.time[-1]))} ms" if done else "")
    if reading.run.failure:
        return f"This run failed after {extent}. {reading.run.failure}"
    if done < asked:
        return f"This run is not complete: it has {extent}. The figures below show that part."
    return ""


def voiced(reading: Reading) -> bool:
    """Whether the main measures mean anything: with an airflow, where the folds vibrate by themselves."""
    return not reading.has("minimum_area") or reading.cycles.verdict not in ("none", "decaying")


def remark(reading: Reading, given: Sequence[Caution] = ()) -> str:
    """The time over which was measured, the cycles of it or why there are none, unless a caution says why."""
    cycles, time = reading.cycles, reading.time
    said = not cycles.note or any(cycles.note in caution.seen for caution in given)
    note = "" if said else f" ({cycles.note})"
    if not cycles.count:
        last = cycles.extent(time)
        over = (
            f" Flow and glottal area are of the last third of the run, from "
            f"{number(1e3 * float(time[last.start]))} to {number(1e3 * float(time[-1]))} ms."
            if reading.has("minimum_area")
            else ""
        )
        return f"No cycles{f': {cycles.note}' if note else ''}.{over}"
    span = [number(1e3 * float(t)) for t in (cycles.starts[0], cycles.starts[-1])]
    over = f"{cycles.count} cycles, from {span[0]} to {span[1]} ms{note}."
    if voiced(reading):
        return f"Measured over {over}"
    return f"No voice. What has a value is of the last {over}"


def sections(reading: Reading, heard: SoundReading | None = None) -> list[tuple[str, list[Drawing]]]:
    """The figures for the data of this run, by section, with those of its sound where it is given."""
    found: list[tuple[str, list[Drawing]]] = []
    if reading.has("minimum_area", "flow"):
        found.append(("Glottis", [glottal_waveforms(reading), kymogram(reading), whole_run(reading)]))
        if reading.has("flow_below"):
            found.append(("Air", [air_at_the_glottis(reading)]))
        one_cycle = [
            coronal_cycle(reading),
            superior_cycle(reading),
            pressure_map(reading),
            trajectories(reading),
        ]
        found.append(("One cycle", [drawing for drawing in one_cycle if drawing]))
        if heard is not None:
            found.append(("Sound", heard.drawings))
    elif reading.has("probes") and reading.waveforms["probes"].size:
        found.append(("Vibration", [probe_motion(reading), probe_spectrum(reading)]))
    if reading.has("contact_force_first") and reading.wave("contact_force_first").any():
        found.append(("Contact", [contact_forces(reading)]))
    if reading.has("kinetic_energy", "elastic_energy", "energy_balance_error"):
        found.append(("Energy", [energy_balance(reading)]))
    return found
