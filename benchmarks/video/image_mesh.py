"""Larynges fitted to single laryngeal frames: contour error, cells, and which frames are refused and why.

    python -m benchmarks.video.image_mesh ../shared/data/laryngeal/bagls_mini
    python -m benchmarks.video.image_mesh ../shared/data/laryngeal/bagls_mini --pictures overlays --mask-alone
    python -m benchmarks.video.image_mesh ../shared/data/laryngeal/laves_endoscopy --label 3
    python -m benchmarks.video.image_mesh analysis       # of plica video: all its frames

The folder has frames N.png and masks N_seg.png drawn by experts, or NAME.png and NAME_labels.png, or is an
analysis. Their scale is unknown: half the folds' length is taken as 7 mm, so that lengths are comparable and
nothing more. Contour error: distances in px between the contour and the glottal edge that the camera sees
through the mesh, both ways; "missed" is its 95th percentile over the half-width.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from benchmarks.harness.study import record, script_parser
from plica import InvalidInput, larynx_fit, video
from plica.video.files.image_file import read_image

COLUMNS = (
    *("frame", "length (px)", "half-width (px)", "contour error: mean (px)", "95 % (px)", "largest (px)"),
    *("95 % over half-width", "least dihedral angle"),
)


def main() -> None:
    parser = script_parser(__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--larynx", default="demo", help="preset: coarse, demo, fine, finest")
    parser.add_argument("--order", type=int, default=2)
    parser.add_argument("--label", type=int, default=3, help="of the glottis in maps NAME_labels.png")
    parser.add_argument("--mask-alone", action="store_true", help="the contour is the mask's own outline")
    parser.add_argument("--pictures", type=Path, help="folder for the overlays (SVG)")
    options = parser.parse_args()
    fitted, refused = [], []
    for name, frame, mask in _frames(options.folder, options.label):
        try:
            made = larynx_fit.fit_larynx(
                None if options.mask_alone else frame,
                mask,
                r_in="7 mm",
                larynx=options.larynx,
                order=options.order,
            )
        except InvalidInput as error:
            refused.append([name, str(error).split(". ")[0]])
            continue
        fitted.append((name, made))
        if options.pictures is not None:
            options.pictures.mkdir(parents=True, exist_ok=True)
            (options.pictures / f"{name}.svg").write_text(larynx_fit.overlay(made).svg, encoding="utf-8")
    rows = [_row(name, made) for name, made in fitted]
    record("image_mesh", COLUMNS, rows, _said([made for _, made in fitted]))
    record("image_mesh_refused", ["frame", "refused for"], refused)


def _row(name: str, made: larynx_fit.LarynxFit) -> list[str]:
    error, ends = made.error, made.section.commissures
    return [
        name,
        f"{np.hypot(*(ends[0] - ends[1])):.0f}",
        f"{made.section.half_width / made.camera.pixel:.1f}",
        *(f"{px:.2f}" for px in (error.mean, error.percentile_95, error.largest)),
        f"{100 * made.missed_width:.0f} %" + " (warned)" * bool(made.warnings),
        f"{made.quality.least_dihedral:.1f}°",
    ]


def _said(fits: list[larynx_fit.LarynxFit]) -> str:
    """Medians and the worst."""
    if not fits:
        return "None is fitted."
    errors = np.array([[one.error.mean, one.error.percentile_95, one.error.largest] for one in fits])
    median, worst = (", ".join(f"{px:.2f}" for px in of(errors, axis=0)) for of in (np.median, np.max))
    least = min(one.quality.least_dihedral for one in fits)
    warned = sum(bool(one.warnings) for one in fits)
    return (
        f"{len(fits)} fitted, {warned} of them with a warning. Contour error (px), mean, 95 %, largest: "
        f"medians {median}, worst {worst}. Least dihedral angle of all {least:.1f}°."
    )


def _frames(folder: Path, label: int) -> Iterator[tuple[str, np.ndarray, np.ndarray]]:
    """Name, grey frame and mask of each frame of a folder."""
    if (folder / "results.h5").exists():
        found = video.load(folder)
        for number in range(found.count):
            yield str(number), found.frames().frame(number), found.mask(number)
        return
    drawn = sorted(folder.glob("*_seg.png"), key=lambda path: int(path.stem.removesuffix("_seg")))
    for path in drawn:
        name = path.stem.removesuffix("_seg")
        yield name, read_image(path.with_name(f"{name}.png")), read_image(path) > 127
    for path in sorted(folder.glob("*_labels.png")):
        name = path.stem.removesuffix("_labels")
        yield name, read_image(path.with_name(f"{name}.png")), read_image(path) == label


if __name__ == "__main__":
    main()
