"""Paper A, Figs. 3, 4, 5 and 8: how the folds move, and where they press on each other."""

from __future__ import annotations

import numpy as np
from matplotlib.collections import PolyCollection
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from benchmarks.thesis.plate import Plate
from benchmarks.thesis.reading import Record, Shelf
from benchmarks.thesis.wording import number
from plica.report.drawing import blue, green, grey, red, rim, tissue

TRANSIENT, SHOWN = 0.02, 0.04  # s: what the thesis omits, and as far as it shows
LOWEST, EXIT, HIGHEST = -0.451, -0.039, 0.031  # cm: S8, S26 and S36


def motion(shelf: Shelf) -> Plate | None:
    record = shelf.get("B")
    if record is None:
        return None
    run = record.run
    time = run.time
    shown = time <= SHOWN
    height = 1e2 * np.asarray(run.section_height)
    canal = (height >= LOWEST) & (height <= HIGHEST)
    coronal = 1e2 * np.asarray(run.waveforms["coronal_right"])[:, canal]
    right = coronal[shown]
    probes = np.asarray(run.waveforms["probes"])
    rest = {name: record.points[record.node(name)] for name in ("6157", "6390")}
    x = {name: 1e2 * (rest[name][0] + probes[:, k, 0]) for k, name in ((0, "6157"), (2, "6390"))}
    steady = (time > TRANSIENT) & (time <= SHOWN)
    vertical = 10 * np.ptp(coronal[record.steps][:, height[canal] <= EXIT, 2], axis=0)

    def paint(figure: Figure) -> None:
        paths, waves = figure.subplots(1, 2, width_ratios=(1, 1.6))
        for i in range(right.shape[1]):
            paths.plot(right[:, i, 0], right[:, i, 2], color=blue, lw=0.4)
        paths.plot(right[0, :, 0], right[0, :, 2], "o--", color=grey, ms=3, lw=0.7)
        paths.set_xlabel("x (cm)")
        paths.set_ylabel("z (cm)")
        paths.set_aspect("equal")
        waves.plot(1e3 * time[steady], x["6157"][steady], color=blue, label="6157: upper canal")
        waves.plot(1e3 * time[steady], x["6390"][steady], "--", color=red, label="6390: lower entry")
        waves.axhline(0, color=grey, lw=0.6)
        waves.set_xlabel("time (ms)")
        waves.set_ylabel("x (cm)")
        waves.set_ylim(top=1.2 * max(x["6390"].max(), x["6157"].max()))
        waves.legend(loc="upper right", ncols=2)

    f0, lowest = record.value("fundamental_frequency"), float(x["6157"][time > TRANSIENT].min())
    grows = "grows upward as in the thesis" if vertical[-1] > vertical[0] else "does not grow upward"
    text = (
        f"The vertical motion {grows} ({vertical[0]:.2f} mm at S8, {vertical[-1]:.2f} mm at the glottal "
        f"exit); f0 is {number(f0, 0)} Hz instead of about 219 Hz ([phonation](phonation.md)), and contact "
        f"stops the upper node at x = {1e1 * lowest:.3f} mm."
    )
    every = slice(0, None, 4)
    return Plate(
        "fig03",
        "Figure 3: trajectories and waveforms of interface nodes",
        "Paths in the mid-coronal plane in the first 0.04 s, and x of two nodes after 0.02 s.",
        text,
        ["time (ms)", "x of 6157 (cm)", "x of 6390 (cm)"]
        + [f"{axis}{i} (cm)" for i in range(right.shape[1]) for axis in "xz"],
        [
            [1e3 * t, a, b, *points[:, [0, 2]].ravel()]
            for t, a, b, points in zip(
                time[shown][every],
                x["6157"][shown][every],
                x["6390"][shown][every],
                right[every],
                strict=True,
            )
        ],
        (7.6, 2.9),
        paint,
    )


def outline(points: np.ndarray, faces: np.ndarray, reference: np.ndarray) -> np.ndarray:
    """The line (k, 2) m in x and z of a surface that lay at y = 0 in the reference, from below upward."""
    edges = np.unique(np.sort(np.concatenate((faces[:, :2], faces[:, 1:], faces[:, ::2])), axis=1), axis=0)
    y = reference[edges, 1]
    crossing = (y.min(axis=1) <= 1e-12) & (y.max(axis=1) >= -1e-12)
    a, b = edges[crossing].T
    span = reference[b, 1] - reference[a, 1]
    part = np.divide(-reference[a, 1], span, out=np.zeros(len(a)), where=np.abs(span) > 1e-12)
    rest = reference[a] + part[:, None] * (reference[b] - reference[a])
    moved = points[a] + part[:, None] * (points[b] - points[a])
    first = np.unique(rest[:, 2].round(9), return_index=True)[1]
    return np.asarray(moved[first][:, [0, 2]])


def instants(record: Record) -> list[tuple[str, int]]:
    """Frames of a typical cycle: closing, pressed together, parting, opening."""
    part = record.typical
    if part is None:
        return []
    area = record.wave("minimum_area")[part]
    force = record.force[part]
    touching = np.flatnonzero(force > 0.01 * force.max())
    peak, half = int(np.argmax(area)), 0.5 * area.max()
    closing = peak + int(np.argmax(area[peak:] < half))
    after = np.asarray(record.wave("minimum_area")[part.start + touching[-1] :])
    opening = int(touching[-1]) + int(np.argmax(after > half))
    frames = (closing, int(np.argmax(force)), int(touching[-1]), opening)
    names = ("closing", "largest force", "last contact", "opening")
    return [(name, part.start + frame) for name, frame in zip(names, frames, strict=True)]


def glottal_shape(shelf: Shelf) -> Plate | None:
    record = shelf.get("B")
    if record is None or record.typical is None:
        return None
    sides = {side: np.asarray(record.run.mesh.surfaces[f"airway_{side}"]) for side in ("left", "right")}
    lines, rows = [], []
    for name, frame in instants(record):
        x = record.points + np.asarray(record.run.displacement[frame], dtype=float)
        both = {side: 1e2 * outline(x, faces, record.points) for side, faces in sides.items()}
        lines.append((name, 1e3 * float(record.time[frame]), both))
        rows += [
            [name, 1e3 * float(record.time[frame]), side, *point]
            for side, line in both.items()
            for point in line
        ]

    def paint(figure: Figure) -> None:
        for axes, (name, time, both) in zip(figure.subplots(1, len(lines), sharey=True), lines, strict=True):
            for side, line in both.items():
                axes.fill_betweenx(
                    line[:, 1], line[:, 0], 0.3 if side == "right" else -0.3, color=tissue, lw=0
                )
                axes.plot(line[:, 0], line[:, 1], color=rim, lw=0.8)
            axes.set(xlim=(-0.25, 0.25), ylim=(-0.6, 0.15), title=f"{name}\n{time:.2f} ms", xlabel="x (cm)")
            axes.set_aspect("equal")
        figure.axes[0].set_ylabel("z (cm)")

    closing, opening = (
        record.value(name) for name in ("diverging_while_closing", "converging_while_opening")
    )
    text = (
        f"The glottis diverges in {number(closing, 2)} of the closing and converges in "
        f"{number(opening, 2)} of the opening samples: the published alternation, but not throughout."
    )
    return Plate(
        "fig04",
        "Figure 4: the glottis in a coronal section",
        "Diverging while closing, a long contact, converging from the collision on.",
        text,
        ["instant", "time (ms)", "fold", "x (cm)", "z (cm)"],
        rows,
        (7.6, 2.9),
        paint,
    )


def flow(shelf: Shelf) -> Plate | None:
    records = {base: shelf.get(base) for base in ("B", "P")}
    found = {base: record for base, record in records.items() if record is not None}
    if "B" not in found:
        return None
    shown = found["B"].run.time <= 0.1
    time = 1e3 * found["B"].run.time[shown]
    flows = {base: 1e6 * np.asarray(record.run.waveforms["flow"])[shown] for base, record in found.items()}

    def paint(figure: Figure) -> None:
        axes = figure.subplots()
        axes.axhspan(500, 600, color=grey, alpha=0.25, lw=0)
        for base, colour in (("P", green), ("B", blue)):
            if base in flows:
                axes.plot(time, flows[base], color=colour, lw=0.8, label=base)
        axes.set(xlabel="time (ms)", ylabel="flow (cm³/s)", xlim=(0, time[-1]))
        axes.legend(loc="upper left", ncols=2)

    peaks = ", ".join(f"{base} {number(r.value('peak_flow', 1e6), 0)}" for base, r in sorted(found.items()))
    settles = ", ".join(f"{base} after {1e3 * settling(r):.0f} ms" for base, r in sorted(found.items()))
    text = (
        f"Largest flow (cm³/s, mean of the cycles): {peaks}; published 500 to 600 (grey). The peaks come "
        f"within 10 % of that: {settles}, instead of about 20 ms."
    )
    return Plate(
        "fig05",
        "Figure 5: volume flow",
        "A transient of about 0.02 s, then steady oscillation with peaks of 500 to 600 cm³/s.",
        text,
        ["time (ms)", *(f"flow {base} (cm3/s)" for base in flows)],
        [list(row) for row in zip(time[::2], *(values[::2] for values in flows.values()), strict=True)],
        (7.6, 2.2),
        paint,
    )


def settling(record: Record) -> float:
    """s after which 10 ms never again pass with a peak flow of less than 90 % of the steady cycles'."""
    steady = record.value("peak_flow")
    flow = np.asarray(record.run.waveforms["flow"])
    count = round(0.01 / record.run.scene.time.step)
    peaks = np.lib.stride_tricks.sliding_window_view(flow, count).max(axis=1)
    low = np.flatnonzero(peaks < 0.9 * (steady.mean if steady else np.inf))
    return float(record.run.time[low[-1]] if low.size else 0.0)


def surface_forces(shelf: Shelf) -> Plate | None:
    record = shelf.get("B")
    if record is None or record.typical is None:
        return None
    part = record.typical
    force = record.force[part]
    touching = np.flatnonzero(force > 0.1 * force.max())
    frames = [part.start + int(touching[-1 - back]) for back in (2, 0)]
    faces = np.asarray(record.run.mesh.surfaces["airway_right"])
    height = np.asarray(record.run.section_height)
    slot = np.searchsorted(record.nodes, faces)
    views, rows = [], []
    for frame in frames:
        x = record.points + np.asarray(record.run.displacement[frame], dtype=float)
        contact = record.nodal_force[frame][slot].sum(axis=1)
        pressure = np.interp(
            record.points[faces, 2],
            height,
            record.wave("section_pressure")[frame],
            left=airway(record),
            right=0.0,
        )
        corners = x[faces]
        normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        air = pressure.mean(axis=1) * 0.5 * np.abs(normal[:, 0])
        total = contact + air
        views.append((1e3 * float(record.time[frame]), 1e2 * corners[:, :, 1:], total))
        middle = 1e2 * corners.mean(axis=1)
        rows += [
            [1e3 * float(record.time[frame]), *p[1:], c, a]
            for p, c, a in zip(middle, contact, air, strict=True)
            if p[2] > -0.6
        ]
    largest = 1e4 * max(view[2].max() for view in views)

    def paint(figure: Figure) -> None:
        scale = Normalize(0, largest)
        panels = figure.subplots(2, 1, sharex=True)
        for axes, (time, corners, total) in zip(panels, views, strict=True):
            drawn = PolyCollection(
                list(corners), array=1e4 * total, cmap="Greys", norm=scale, lw=0.2, ec="0.7"
            )
            axes.add_collection(drawn)
            axes.set(xlim=(-0.72, 0.72), ylim=(-0.46, 0.12), ylabel="z (cm)", title=f"{time:.2f} ms")
        panels[-1].set_xlabel("y (cm)")
        figure.colorbar(drawn, ax=panels, label="force on a triangle (10⁻⁴ N)")

    places = np.concatenate(
        [[np.abs(corners.mean(axis=1)[np.argmax(total), 0])] for _, corners, total in views]
    )
    length = record.value("contact_length_fraction")
    text = (
        f"The largest force on a triangle is {largest:.0f}e-4 N (triangles are larger "
        "here, and multipliers act in single steps), "
        f"{' and '.join(f'{y:.2f}' for y in places)} cm from the mid-coronal plane; contact covers "
        f"{number(length, 2, 100)} % of the fold's length at most."
    )
    return Plate(
        "fig08",
        "Figure 8: contact and air forces on the right fold while it parts",
        "Sagittal view at two instants: contact reaches the glottal exit, largest in the mid-coronal "
        "plane, about 1e-4 N a triangle, along 40 % of the length.",
        text,
        ["time (ms)", "y (cm)", "z (cm)", "contact force (N)", "air force (N)"],
        rows,
        (6.4, 4.2),
        paint,
    )


def airway(record: Record) -> float:
    """Pa below the first section."""
    return 1e3 * record.case.pressure
