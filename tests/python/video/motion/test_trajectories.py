"""Material points through the exact flow of the synthetic glottis."""

from __future__ import annotations

import numpy as np

from plica.measures.cycles import find_cycles
from plica.synthetic.glottis import Synthetic, SyntheticGlottis
from plica.video.motion.trajectories import follow


def test_points_follow_the_exact_motion_and_close_their_cycles() -> None:
    glottis = SyntheticGlottis(Synthetic(height=96, width=96, frames=101, frequency=0.05, opening=(12, 12)))
    flows = [glottis.flow(t, t + 1)[0] for t in range(100)]
    points = np.array([[20.0, 48], [25, 40], [75, 48], [80, 60]])
    paths = follow(flows, points)
    time = np.arange(101.0)
    area = np.array([sum(glottis.area(t)) for t in time])
    cycles = find_cycles(time, area)
    assert cycles.count >= 3
    swing = np.ptp(paths.places[..., 0], axis=0)
    assert (swing > 3).all()
    assert (paths.closing_error(cycles, time) < 0.02 * swing).all()
    assert np.array_equal(paths.places[:, :, 1], np.broadcast_to(points[:, 1], (101, 4)))  # no motion along y


def test_a_point_that_leaves_the_frame_is_lost_and_the_others_stay() -> None:
    flow = np.zeros((20, 20, 2))
    flow[..., 0] = 3.0
    paths = follow([flow] * 4, np.array([[10.0, 10], [2, 2]]))
    assert np.isnan(paths.places[-1, 0, 0])
    assert paths.places[-1, 1].tolist() == [14.0, 2.0]
