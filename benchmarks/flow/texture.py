"""Error of the flow by preset where tissue is faint, coarse, blurred or noisy: the synthetic glottis.

    python -m benchmarks.flow.texture

160 x 160 px, five pairs each of two recordings a row (seeds 91 and 92), constant light, with the mask of
`plica video`. Mean distance (px) from the true flow of all tissue. "Brightness": the preset
`robust` with a smoothness of 0.5.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

import plica
from benchmarks.harness.study import record, script_parser
from plica.synthetic.glottis import Synthetic, SyntheticGlottis
from plica.video.motion.flow import flow
from plica.video.motion.frame_content import Seen, informing

GLOTTIS = {"height": 160, "width": 160, "amplitude": (6, 5), "opening": (3, 3), "highlights": 0}
TEXTURES = (  # noise, contrast (grey), blur, grain (px)
    (2, 25, 0.8, 2),
    (10, 25, 0.8, 2),
    (2, 8, 0.8, 2),
    (5, 8, 0.8, 2),
    (2, 25, 2.5, 2),
    (5, 12, 2.5, 2),
    (2, 25, 0.8, 5),
    (5, 10, 0.8, 5),
)
WAYS = {
    "video": {"preset": "video"},
    "video, smoothness 0.2": {"preset": "video", "smoothness": 0.2},
    "gradient": {"preset": "gradient"},
    "fast": {"preset": "fast"},
    "brightness": {"preset": "robust", "smoothness": 0.5},
}
TIMES = (2, 6, 10, 14, 18)


def error(glottis: SyntheticGlottis, t: int, way: dict[str, object]) -> float:
    one, two = (Seen(glottis.frame(k), glottis.mask(k)) for k in (t, t + 1))
    options = {"mask": informing(one, two), "intensity": (0.0, 255.0), "light": "none"}
    truth, known = glottis.flow(t, t + 1)
    off = flow(one.frame, two.frame, **options, **way).flow - truth
    return float(np.hypot(*np.moveaxis(off, -1, 0))[one.tissue & known].mean())


def rows() -> Iterator[list[str]]:
    for noise, texture, blur, grain in TEXTURES:
        look = {"noise": float(noise), "texture": float(texture), "blur": blur, "grain": float(grain)}
        glottises = [SyntheticGlottis(Synthetic(**GLOTTIS, **look, seed=seed)) for seed in (91, 92)]
        means = (np.mean([error(one, t, way) for one in glottises for t in TIMES]) for way in WAYS.values())
        yield [f"{noise}, {texture}, {blur}, {grain}", *(f"{mean:.3f}" for mean in means)]


def main() -> None:
    script_parser(__doc__).parse_args()
    plica.set_threads(1)
    record("flow_texture", ["noise, contrast (grey), blur, grain (px)", *WAYS], rows())


if __name__ == "__main__":
    main()
