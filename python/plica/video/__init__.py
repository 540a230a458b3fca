"""High-speed recordings of the larynx: glottis, tissue motion, modes.

The command ``plica video`` as functions::

    from plica import video

    settings = video.Settings(fps=4000, mm_per_px=0.05)
    found = video.analyse("larynx.avi", "analysis", settings)
    print(found.measures["fundamental_frequency"])
    motion = found.flow(10)        # (h, w, 2) px, from frame 10 to 11
    table = found.to_xarray()      # waveforms, a row a frame
    changes = video.compare("before", "after").changes

Each step stands alone too: `Recording`, `masks`, `find_midline`, `areas`, `kymogram`, `plica.flow`, `follow`,
`plica.video.drift.drift`, `plica.video.modes.modes`; `plica.video.report.write_report` writes the page.
"""

from __future__ import annotations

from plica.video.analysis import Analysis, analyse, load
from plica.video.candidates import Prior
from plica.video.comparison import Comparison, compare
from plica.video.drift import Steadied
from plica.video.errors import VideoError
from plica.video.flow import PRESETS, FlowOptions, PairFlow, endpoint_error, warp_error
from plica.video.flow_file import read_flow, write_flow
from plica.video.glottal_area import GlottalArea, areas
from plica.video.glottis import Look, learn, masks, read_masks, write_masks
from plica.video.kymogram import kymogram
from plica.video.midline import Midline, find_midline
from plica.video.modes import Modes
from plica.video.network import Network
from plica.video.recording import Recording, Region
from plica.video.segmentation import Glottis, segment
from plica.video.settings import Settings
from plica.video.synthetic import Synthetic, SyntheticGlottis
from plica.video.tables import write_tables
from plica.video.trajectories import Paths, follow
from plica.video.waveforms import measures, phases

__all__ = [
    "PRESETS",
    "Analysis",
    "Comparison",
    "FlowOptions",
    "GlottalArea",
    "Glottis",
    "Look",
    "Midline",
    "Modes",
    "Network",
    "PairFlow",
    "Paths",
    "Prior",
    "Recording",
    "Region",
    "Settings",
    "Steadied",
    "Synthetic",
    "SyntheticGlottis",
    "VideoError",
    "analyse",
    "areas",
    "compare",
    "endpoint_error",
    "find_midline",
    "follow",
    "kymogram",
    "learn",
    "load",
    "masks",
    "measures",
    "phases",
    "read_flow",
    "read_masks",
    "segment",
    "warp_error",
    "write_flow",
    "write_masks",
    "write_tables",
]
