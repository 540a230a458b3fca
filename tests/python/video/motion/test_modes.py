"""Modes of planted flows: principal angles, shares, signs, symmetry."""

from __future__ import annotations

from pathlib import Path

import h5py
import numpy as np
import pytest

from plica.video.errors import VideoError
from plica.video.glottis.midline import Midline
from plica.video.motion import modes as module
from plica.video.motion.modes import modes

_SHAPE, _FRAMES, _COLUMN = (40, 30), 50, 14.5
_MIDLINE = Midline((_COLUMN, 0.0), (_COLUMN, 39.0))


def planted(noise: float = 0.0) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Flows of two modes, symmetric and antisymmetric, with shares 0.9 and 0.1; the modes; the
    coefficients."""
    y, x = np.mgrid[0 : _SHAPE[0], 0 : _SHAPE[1]].astype(float)
    bell = np.exp(-((x - _COLUMN) ** 2) / 60 - (y - 20) ** 2 / 100)
    together = np.stack([np.sign(x - _COLUMN) * bell, 0.2 * bell], axis=-1)
    opposite = np.stack([bell, 0 * bell], axis=-1)
    shapes = np.stack([w / np.linalg.norm(w) for w in (together, opposite)])
    t = np.arange(_FRAMES)
    time = np.stack([np.sin(2 * np.pi * t / 10), np.cos(2 * np.pi * t / 10)], axis=1)
    time *= np.sqrt([0.9, 0.1]) * 30
    flows = np.tensordot(time, shapes, 1) + 0.7
    random = np.random.default_rng(3)
    return flows + noise * random.standard_normal(flows.shape), shapes, time


def test_planted_modes_and_their_shares_are_found() -> None:
    flows, shapes, time = planted()
    found = modes(flows, 4, midline=_MIDLINE)
    assert found.share.size == 2  # round-off is no mode
    assert found.share == pytest.approx([0.9, 0.1], abs=1e-9)
    assert np.abs(np.tensordot(found.patterns, shapes, ((1, 2, 3), (1, 2, 3))) - np.eye(2)).max() < 1e-7
    assert found.coefficients == pytest.approx(time - time.mean(axis=0), abs=1e-6)
    assert found.mean == pytest.approx(np.full((*_SHAPE, 2), 0.7), abs=1e-9)
    assert found.symmetry(_MIDLINE) == pytest.approx([1, -1], abs=1e-9)
    assert found.variance == pytest.approx(flows.var(axis=0, ddof=1).sum())
    rebuilt = found.mean + np.tensordot(found.coefficients, found.patterns, 1)
    assert rebuilt == pytest.approx(flows, abs=1e-8)


def test_a_mode_has_the_sign_in_which_the_folds_part() -> None:
    """Though the fold on the left, which parts by negative u, swings further."""
    y, x = np.mgrid[0 : _SHAPE[0], 0 : _SHAPE[1]].astype(float)
    bell = np.exp(-((x - _COLUMN) ** 2) / 60 - (y - 20) ** 2 / 100) * np.where(x < _COLUMN, 1.3, 1.0)
    parting = np.stack([np.sign(x - _COLUMN) * bell, 0 * bell], axis=-1)
    flows = np.sin(2 * np.pi * np.arange(_FRAMES) / 10)[:, None, None, None] * parting
    for given in (flows, -flows):
        assert np.sum(modes(given, 1, midline=_MIDLINE).patterns[0] * parting) > 0
        assert np.sum(modes(given, 1).patterns[0] * parting) < 0  # the largest component is positive


def test_symmetry_is_about_the_midline_however_it_leans() -> None:
    """A planted motion towards and from a leaning line, and one across it."""
    y, x = np.mgrid[0:60, 0:60].astype(float)
    for lean in (-12.0, 0.0, 9.0):
        line = Midline((29.5 - lean, 0.0), (29.5 + lean, 59.0))
        along, off = np.moveaxis(line.place(np.stack([x, y], axis=-1)), -1, 0)
        bell = np.exp(-(off**2) / 60 - (along - 30) ** 2 / 200)
        shapes = [(np.tanh(off) * bell)[..., None] * line.across, bell[..., None] * line.across]
        t = np.arange(_FRAMES)[:, None, None, None]
        flows = 3 * np.sin(2 * np.pi * t / 10) * shapes[0] + np.cos(2 * np.pi * t / 10) * shapes[1]
        found = modes(flows, 2, midline=line)
        assert found.symmetry(line) == pytest.approx([1, -1], abs=0.01)
        assert np.sum(found.patterns[0] * shapes[0]) > 0
        if lean:
            upright = Midline((29.5, 0.0), (29.5, 59.0))
            assert found.symmetry(upright)[0] < 0.95


def test_noise_takes_the_share_that_its_variance_says() -> None:
    noise = 0.1
    found = modes(planted(noise)[0], 2, midline=_MIDLINE)
    signal = 900 * _FRAMES / (_FRAMES - 1) / 2
    of_noise = noise**2 * 2 * _SHAPE[0] * _SHAPE[1]
    assert found.variance == pytest.approx(signal + of_noise, rel=0.03)
    assert found.share.sum() == pytest.approx(signal / (signal + of_noise), abs=0.03)
    angle = np.linalg.svd(
        np.tensordot(found.patterns, planted()[1], ((1, 2, 3), (1, 2, 3))), compute_uv=False
    )
    assert angle.min() > np.cos(0.15)


def test_blocks_a_mask_and_a_file_give_the_same(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    flows = planted(0.05)[0]
    mask = np.zeros(_SHAPE, dtype=bool)
    mask[5:35, 3:28] = True
    whole = modes(flows, 3, mask, _MIDLINE)
    flows[:, ~mask] = np.nan
    with h5py.File(tmp_path / "flow.h5", "w") as file:
        file["flow"] = flows
        monkeypatch.setattr(module, "_BLOCK", 16 * _FRAMES * _SHAPE[1] * 7)  # seven rows
        blocks = modes(file["flow"], 3, mask, _MIDLINE)
    assert blocks.patterns == pytest.approx(whole.patterns, abs=1e-9)
    assert blocks.share == pytest.approx(whole.share, rel=1e-12)
    assert not whole.patterns[:, ~mask].any()


def test_what_cannot_be_decomposed_is_said() -> None:
    flows = planted()[0]
    for given, count, mask, text in (
        (flows[:2], 1, None, "2 flows; must be three"),
        (flows, 50, None, "count = 50; must be in"),
        (flows, 2, np.zeros(_SHAPE, dtype=bool), "mask has 0 pixels"),
        (np.ones_like(flows), 2, None, "no flow differs"),
    ):
        with pytest.raises(VideoError, match=text):
            modes(given, count, mask)
    flows[7, 3, 3, 0] = np.nan
    with pytest.raises(VideoError, match="flow 7 is not finite"):
        modes(flows, 2)


def test_a_mode_of_the_motion_is_in_both_halves_of_the_frames_and_one_of_errors_is_not() -> None:
    flows, _, _ = planted(noise=0.05)
    found = modes(flows, 5)
    assert found.repeated[:2].min() > 0.9
    assert found.repeated[2:].max() < 0.4
    noise = np.random.default_rng(5).standard_normal((_FRAMES, *_SHAPE, 2))
    assert modes(noise, 4).repeated.max() < 0.4
    once = flows.copy()
    once[_FRAMES // 2 :] = 0.05 * noise[_FRAMES // 2 :]  # a motion of the first half alone
    assert modes(once, 2).repeated.max() < 0.4


def test_a_wave_is_two_modes_that_travel_as_one() -> None:
    y, x = np.mgrid[0 : _SHAPE[0], 0 : _SHAPE[1]].astype(float)
    t = np.arange(_FRAMES)[:, None, None]
    wave = np.sin(2 * np.pi * (t / 10 - y / 20)) * np.exp(-((x - _COLUMN) ** 2) / 60)
    standing = 4 * np.sin(2 * np.pi * t / 10) * np.exp(-((x - _COLUMN) ** 2) / 60 - (y - 20) ** 2 / 100)
    apart = 2 * np.sin(2 * np.pi * t / 7.3) * np.sign(x - _COLUMN) * np.exp(-((y - 20) ** 2) / 100)
    travels = modes(np.stack([wave, 0 * wave], axis=-1), 3)
    assert travels.travelling[0] > 0.95
    assert travels.share[:2].sum() == pytest.approx(1.0, abs=1e-6)
    stands = modes(np.stack([standing + apart, 0 * wave], axis=-1), 3)
    assert stands.travelling[0] < 0.3
    assert np.isnan(stands.travelling[-1])


def test_halves_of_the_gram_matrix_are_those_of_the_flows() -> None:
    flows, _, _ = planted(noise=0.1)
    both = [part.reshape(len(part), -1) for part in (flows[:25], flows[25:])]
    one, other = (np.linalg.svd(part - part.mean(axis=0), full_matrices=False)[2] for part in both)
    true = [np.linalg.norm(other[: k + 2] @ one[k]) for k in range(4)]
    assert modes(flows, 4).repeated == pytest.approx(true, abs=1e-6)
