"""Segmentation of single laryngeal frames against masks drawn by experts: intersection over union.

    python benchmarks/glottis.py ../shared/data/laryngeal/bagls_mini

Two empty masks agree completely (1), an empty one with another not at all (0). Each frame stands alone here;
in a recording the motion tells where the glottis is, and every frame has the same two grey levels.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

from plica.video.image_file import read_image
from plica.video.segmentation import segment


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("folder", type=Path, help="with N.png and N_seg.png")
    found = []
    for path in sorted(parser.parse_args().folder.glob("*_seg.png")):
        name = path.name.removesuffix("_seg.png")
        truth = read_image(path) > 127
        glottis = segment(read_image(path.with_name(f"{name}.png")))
        union = (truth | glottis.mask).sum()
        overlap = float((truth & glottis.mask).sum() / union) if union else 1.0
        found.append((overlap, name, int(truth.sum()), int(glottis.mask.sum()), glottis.score))
    print("| frame | overlap | true (px) | found (px) | score |\n| --- | --- | --- | --- | --- |")
    for overlap, name, true, area, score in sorted(found):
        print(f"| {name} | {overlap:.2f} | {true} | {area} | {score:.3f} |")
    overlaps = np.array([row[0] for row in found])
    print(
        f"\nmean {overlaps.mean():.2f}, median {np.median(overlaps):.2f}, below 0.5: {(overlaps < 0.5).sum()}"
    )


if __name__ == "__main__":
    main()
