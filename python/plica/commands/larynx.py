"""``plica larynx``: fit the mesh of a scene to an image of the folds."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from plica.commands.arguments import add_command, as_options, number_or_text, numbers
from plica.errors import InvalidInput

if TYPE_CHECKING:
    from plica.larynx_fit import LarynxFit

__all__ = ["add_commands"]

_HELP = """\
Fits the parametric larynx to the glottis in one image, taken from above before phonation, with the folds
apart; writes the mesh of a scene, one line, and an image of the fit (SVG). FRAME is an image (PNG, TIFF,
JPEG, BMP), or the directory of an analysis (plica video) with --frame N, whose mask, pixel size and anterior
end are then used.

An image has no scale. Give either the size of a pixel (--mm-per-px), and the length is measured; or half the
folds' length (--r-in), and the size of a pixel follows. Nor does it show depth: the heights z0 to z5 and the
thickness of the layers are those of the thesis by default.

Contour error is the distance between the contour and the mesh's glottal edge as seen by the camera. The
larynx is elliptic and symmetric: if it misses the contour by more than --largest-error of the visible
length, the frame is refused.

examples:
  plica larynx frame.png --mask mask.png --mm-per-px 0.06 -o scene-mesh.toml
  plica larynx frame.png --r-in "7 mm" --l-occ "1 mm" -o scene-mesh.toml      the pixel's size from the length
  plica larynx analysis --frame 0 -o scene-mesh.toml                          frame 0 of plica video

Use the output as the start of a scene file; docs/image_mesh.md describes the accuracy. In Python:
plica.larynx_fit.
"""


def add_commands(commands: Any) -> None:
    """Add ``larynx`` to the commands of ``plica``."""
    part = add_command(commands, "larynx", _larynx, "fit a larynx to an image of the folds", _HELP)
    part.add_argument("frame", metavar="FRAME", type=Path, help="an image, or DIR of an analysis")
    part.add_argument("-o", "--output", metavar="FILE", type=Path, required=True, help="the mesh (TOML)")
    part.add_argument("--mask", metavar="FILE", type=Path, help="image, white where the glottis is")
    part.add_argument("--frame", dest="number", metavar="N", type=int, help="frame of an analysis, from 0")
    part.add_argument("--mm-per-px", metavar="MM", type=float, help="size of a pixel")
    part.add_argument(
        "--r-in", metavar="LENGTH", type=number_or_text, help='half the folds\' length, e.g. "7 mm"'
    )
    part.add_argument("--wall", metavar="LENGTH", type=number_or_text, help="r_out - r_in (default: 1 mm)")
    part.add_argument(
        "--l-occ",
        metavar="LENGTH",
        type=number_or_text,
        help="length that is hidden by cartilage (default: 0)",
    )
    part.add_argument(
        "--heights",
        dest="z",
        metavar="Z0,...,Z5",
        type=numbers(float, 6),
        help="mm, upward (default: -12,-7,-4,0,2,12)",
    )
    part.add_argument(
        "--layer-thickness",
        metavar="LENGTH",
        type=number_or_text,
        help="of cover and ligament (default: 0.5 mm)",
    )
    part.add_argument(
        "--tilt", metavar="DEG", type=float, help="inclination of the camera towards anterior (default: 0)"
    )
    part.add_argument(
        "--lean",
        metavar="DEG",
        type=float,
        help="inclination of the camera towards the right fold (default: 0)",
    )
    part.add_argument(
        "--anterior",
        metavar="END",
        help="anterior end of the glottis in the image: upper or lower (default: upper)",
    )
    part.add_argument(
        "--commissures",
        metavar="X,Y,X,Y",
        type=numbers(float, 4),
        help="px, A and P0, the anterior and posterior end of the visible glottis (default: fitted)",
    )
    part.add_argument("--larynx", metavar="NAME", help="coarse, demo, fine or finest cells (default: demo)")
    part.add_argument("--order", metavar="1|2", type=int, help="2: quadratic tetrahedra (default)")
    part.add_argument("--largest-error", metavar="SHARE", type=float, help="default: 0.05")
    part.add_argument("--overwrite", action="store_true", help="replace existing files")


_OPTIONS = {"z": "--heights"}


def _larynx(options: argparse.Namespace) -> int:
    with as_options(("Larynx fit",), _OPTIONS):
        return _fitted(options)


def _fitted(options: argparse.Namespace) -> int:
    from plica import larynx_fit
    from plica.storage.files import refuse_overwriting, replaced, write_text

    picture = options.output.with_suffix(".svg")
    refuse_overwriting([options.output, picture], options.overwrite)
    frame, mask, known = _of_analysis(options) if options.frame.is_dir() else _of_picture(options)
    names = ("mm_per_px", "r_in", "wall", "l_occ", "layer_thickness", "tilt", "lean", "anterior", "larynx")
    given = {name: getattr(options, name) for name in (*names, "order", "largest_error")}
    given = {name: value for name, value in given.items() if value is not None}
    if options.r_in is not None:
        known.pop("mm_per_px", None)
    if options.z is not None:
        given["z"] = tuple(1e-3 * z for z in options.z)
    if options.commissures is not None:
        x, y, other_x, other_y = options.commissures
        given["commissures"] = ((x, y), (other_x, other_y))
    made = larynx_fit.fit_larynx(frame, mask, **(known | given))
    scene, seen = _comment(made) + made.scene_text(), larynx_fit.overlay(made).svg

    def write_both(draft: Path) -> None:
        draft.write_text(seen, encoding="utf-8")
        write_text(scene, options.output)

    replaced(picture, write_both)
    print(_summary(made))
    print(f"\nwritten: {options.output}, {picture}")
    for warning in made.warnings:
        print(f"plica: Caution: {warning}", file=sys.stderr)
    return 0


def _of_picture(options: argparse.Namespace) -> tuple[Any, Any, dict[str, Any]]:
    if options.number is not None:
        raise InvalidInput(f"--frame {options.number} is for analyses; {options.frame} is an image.")
    mask = None if options.mask is None else _read(options.mask)
    return _read(options.frame), None if mask is None else mask > 0.5 * max(float(mask.max()), 1.0), {}


def _read(path: Path) -> Any:
    """Read an image; error messages start with the path."""
    from plica.video.files.image_file import read_image

    try:
        return read_image(path)
    except InvalidInput as error:
        raise InvalidInput(str(error).removeprefix("read_image: ")) from None


def _of_analysis(options: argparse.Namespace) -> tuple[Any, Any, dict[str, Any]]:
    from plica import video

    if options.number is None or options.mask is not None:
        raise InvalidInput(f"{options.frame} is a directory; must come with --frame N and without --mask.")
    found = video.load(options.frame)
    mask = found.mask(options.number)
    known = {"mm_per_px": found.settings.mm_per_px, "anterior": found.settings.anterior}
    frame = found.frames().frame(options.number % found.count)
    return frame, mask, {name: value for name, value in known.items() if value is not None}


def _comment(made: LarynxFit) -> str:
    """A comment with the position of the larynx in the image, which the table cannot hold."""
    camera = made.camera
    centre = ", ".join(f"{1e3 * float(x):.5g}" for x in camera.centre)
    return (
        f"# Fitted to an image of {camera.width} x {camera.height} px: plica.Camera(mm_per_px="
        f"{camera.mm_per_px:.6g},\n# roll={camera.roll:.4f}, tilt={camera.tilt:g}, lean={camera.lean:g}) "
        f"with its centre at ({centre}) mm.\n"
    )


def _summary(made: LarynxFit) -> str:
    """The result as text."""
    section, error, quality, contour = made.section, made.error, made.quality, made.contour
    ends = ", ".join(
        f"{name} ({x:.1f}, {y:.1f})"
        for name, (x, y) in zip(("A", "P0", "P"), section.commissures, strict=True)
    )
    return "\n".join(
        [
            f"half-width {1e3 * section.half_width:.3f} mm, r_in {1e3 * section.r_in:.3f} mm, r_out "
            f"{1e3 * section.r_out:.3f} mm, l_occ {1e3 * section.l_occ:.3f} mm",
            f"{ends} px, {made.camera.mm_per_px:.4g} mm per pixel, rotated by {made.camera.roll:.2f} degrees",
            f"openings: {contour.openings}; asymmetry {made.asymmetry:+.3f} (the larynx has none)",
            f"contour error: mean {error.mean:.2f} px, 95 % within {error.percentile_95:.2f} px, largest "
            f"{error.largest:.2f} px",
            f"mesh: {quality.tetrahedra} tetrahedra, {quality.nodes} nodes; least dihedral angle "
            f"{quality.least_dihedral:.1f} degrees, mean ratio {quality.least_mean_ratio:.3f}, det dx/dxi "
            f"{quality.least_jacobian:.3f} of the straight cell's",
        ]
    )
