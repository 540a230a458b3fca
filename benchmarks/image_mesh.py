"""Larynges fitted to single laryngeal frames: contour error, cells, and which frames are refused and why.

    python benchmarks/image_mesh.py ../shared/data/laryngeal/bagls_mini
    python benchmarks/image_mesh.py ../shared/data/laryngeal/bagls_mini --pictures overlays --mask-alone
    python benchmarks/image_mesh.py ../shared/data/laryngeal/laves_endoscopy --label 3
    python benchmarks/image_mesh.py analysis       # of plica video: all its frames

The folder has frames N.png and masks N_seg.png drawn by experts, or NAME.png and NAME_labels.png, or is an
analysis. Their scale is unknown: half the folds' length is taken as 7 mm, so that lengths are comparable and
nothing more. Contour error: distances in px between the contour and the glottal edge that the camera sees
through the mesh, both ways; "missed" is its 95th percentile over the half-width.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from plica import InvalidInput, larynx_fit, video
from plica.video.image_file import read_image

_HEAD = (
    f"{'frame':>5} {'length':>7} {'half-width':>10} {'asymmetry':>9} {'mean':>6} {'95 %':>6} {'max':>6} "
    f"{'missed':>6} {'dihedral':>8} {'ratio':>6} {'det':>5} {'cells':>6} {'time':>5}\n"
    f"{'':>5} {'px':>7} {'px':>10} {'':>9} {'px':>6} {'px':>6} {'px':>6} {'%':>6} {'degrees':>8} "
    f"{'':>6} {'':>5} {'':>6} {'s':>5}"
)


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("folder", type=Path)
    parser.add_argument("--larynx", default="demo", help="preset: coarse, demo, fine, finest")
    parser.add_argument("--order", type=int, default=2)
    parser.add_argument("--label", type=int, default=3, help="of the glottis in maps NAME_labels.png")
    parser.add_argument("--mask-alone", action="store_true", help="the contour is the mask's own outline")
    parser.add_argument("--pictures", type=Path, help="folder for the overlays (SVG)")
    options = parser.parse_args()
    print(_HEAD)
    rows, refused = [], []
    for name, frame, mask in _frames(options.folder, options.label):
        began = time.perf_counter()
        try:
            made = larynx_fit.fit_larynx(
                None if options.mask_alone else frame,
                mask,
                r_in="7 mm",
                larynx=options.larynx,
                order=options.order,
            )
        except InvalidInput as error:
            refused.append((name, str(error)))
            continue
        took = time.perf_counter() - began
        rows.append(_shown(name, made, took))
        if options.pictures is not None:
            options.pictures.mkdir(parents=True, exist_ok=True)
            (options.pictures / f"{name}.svg").write_text(larynx_fit.overlay(made).svg, encoding="utf-8")
    table = np.array(rows)
    if rows:
        for what, row in (("median", np.median(table, axis=0)), ("worst", _worst(table))):
            print(f"{what}: mean {row[0]:.2f}, 95 % {row[1]:.2f}, max {row[2]:.2f} px; dihedral {row[3]:.2f}")
    print(f"\n{len(rows)} of {len(rows) + len(refused)} frames fitted; refused:")
    for name, why in refused:
        print(f"{name:>5}  {why}")


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


def _shown(name: str, made: larynx_fit.LarynxFit, took: float) -> tuple[float, float, float, float]:
    error, quality, ends = made.error, made.quality, made.section.commissures
    width = made.section.half_width / made.camera.pixel
    print(
        f"{name:>5} {np.hypot(*(ends[0] - ends[1])):7.1f} {width:10.2f} "
        f"{made.asymmetry:+9.2f} {error.mean:6.2f} {error.percentile_95:6.2f} {error.largest:6.2f} "
        f"{100 * made.missed_width:6.0f} "
        f"{quality.least_dihedral:8.2f} {quality.least_mean_ratio:6.3f} {quality.least_jacobian:5.2f} "
        f"{quality.tetrahedra:6d} {took:5.1f}"
    )
    return error.mean, error.percentile_95, error.largest, quality.least_dihedral


def _worst(table: np.ndarray) -> np.ndarray:
    return np.array([*table[:, :3].max(axis=0), table[:, 3].min()])


if __name__ == "__main__":
    main()
