"""``plica masks``: masks of an analysis to be corrected by hand, as pictures or on a page."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from plica.commands.arguments import add_command, numbers

__all__ = ["add_masks"]

_HELP = """\
Writes frames of an analysis to be corrected by hand: on a page (--page), or as pictures (-o).

The page is one HTML file that any browser opens, without network. With brush and eraser the outline of the
glottis is corrected, the midline by its ends, the region of the picture by a rectangle, the size of a pixel
by two points whose distance is known. Save puts corrections.json into the folder of downloads; the page says
the command that reads it (plica video or glottis, --corrections).

The pictures are frame_N.png and mask_N.png, white where the glottis is, with N the number of the frame.
Paint in the masks, delete those that need no correction, and give the folder to plica video (or glottis)
with --masks.

Either way the masks are used unchanged, and the other frames are segmented using the darkness and position
of the glottis in them. One drawn mask of a wide open glottis often corrects a whole recording; a black mask
means that the glottis is closed. Masks are stored with the results: new masks are added to earlier ones,
--no-masks removes all. If plica found no glottis, the masks are black.

examples:
  plica masks analysis --page correct.html         twelve frames, spread over the recording
  plica video larynx.avi -o analysis --corrections corrections.json
  plica masks analysis -o drawn
  plica masks analysis --frames 57,120 -o drawn
  plica glottis larynx.avi -o analysis --masks drawn
"""


def add_masks(commands: Any) -> None:
    """Add the command to ``plica``."""
    masks = add_command(
        commands, "masks", _masks, "write masks of an analysis to be corrected by hand", _HELP
    )
    masks.add_argument("analysis", metavar="DIR", type=Path, help="directory of plica video or plica glottis")
    where = masks.add_mutually_exclusive_group(required=True)
    where.add_argument("--page", metavar="FILE", type=Path, help="a page to correct on, correct.html")
    where.add_argument("-o", "--output", metavar="FOLDER", type=Path, help="folder of the pictures")
    masks.add_argument("--frames", metavar="N,N,...", type=numbers(int), help="frames (default: twelve)")
    masks.add_argument("--quiet", action="store_true", help="print only errors and cautions")


def _masks(options: argparse.Namespace) -> int:
    import numpy as np

    from plica.errors import InvalidInput
    from plica.storage.files import storage_errors
    from plica.video.analysis import load
    from plica.video.glottis.segmenter import write_masks
    from plica.video.report.corrections_page import write_corrections_page

    found = load(options.analysis, needs="drift")
    chosen = sorted(set(options.frames or (round(k * (found.count - 1) / 11) for k in range(12))))
    for frame in chosen:
        if not 0 <= frame < found.count:
            raise InvalidInput(f"Masks: frame {frame}; must be in [0, {found.count}).")
    if options.page is not None:
        with storage_errors(options.page):
            write_corrections_page(found, chosen, options.page)
        if not options.quiet:
            print(f"written: {options.page}: open it in a browser, correct, save; it says how to go on")
        return 0
    frames = found.frames()
    black = np.zeros(frames.shape, dtype=bool)
    pictures = {
        k: (frame, found.mask(k) if "glottis" in found else black) for k, frame in frames.some(chosen)
    }
    with storage_errors(options.output):
        write_masks(options.output, pictures)
    if not options.quiet:
        print(f"written: {options.output}: {len(chosen)} frames and their masks")
    return 0
