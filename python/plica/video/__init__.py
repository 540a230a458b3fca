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
`plica.video.motion.drift.drift`, `plica.video.motion.modes.modes`; `plica.video.report.page.write_report`
writes the page.
"""

from __future__ import annotations

from plica.video.analysis import Analysis, analyse, load
from plica.video.errors import VideoError
from plica.video.files.corrections import Corrections, read_corrections
from plica.video.files.recording import Recording, Region
from plica.video.glottis.candidates import Prior
from plica.video.glottis.frame_segmentation import Glottis, segment
from plica.video.glottis.glottal_area import GlottalArea, areas
from plica.video.glottis.kymogram import kymogram
from plica.video.glottis.midline import Midline, find_midline
from plica.video.glottis.network import Network
from plica.video.glottis.segmenter import Look, learn, masks, read_masks, write_masks
from plica.video.measures.waveforms import measures, phases
from plica.video.motion.drift import Steadied
from plica.video.motion.flow import PRESETS, FlowOptions, PairFlow, endpoint_error, warp_error
from plica.video.motion.flow_file import read_flow, write_flow
from plica.video.motion.modes import Modes
from plica.video.motion.trajectories import Paths, follow
from plica.video.report.comparison import Comparison, compare
from plica.video.settings import Settings
from plica.video.tables import write_tables

__all__ = [
    "PRESETS",
    "Analysis",
    "Comparison",
    "Corrections",
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
    "read_corrections",
    "read_flow",
    "read_masks",
    "segment",
    "warp_error",
    "write_flow",
    "write_masks",
    "write_tables",
]
