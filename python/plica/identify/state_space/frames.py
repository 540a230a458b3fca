"""Models from video frame to video frame: several time steps per frame, and motion between two frames."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from plica import _engine
from plica.errors import InvalidInput
from plica.identify.state_space.linear_gaussian import LinearGaussian, PatternNoise, checked_matrix

__all__ = ["compose", "frame_difference"]

Array = NDArray[np.float64]


def compose(
    model: LinearGaussian, substeps: int, f: ArrayLike | None = None
) -> tuple[LinearGaussian, Array | None]:
    """The model from frame to frame, with `substeps` steps of `model` per frame.

    Parameters
    ----------
    model : LinearGaussian
        The model of one step; y is observed after every `substeps` of them.
    substeps : int
        s >= 1.
    f : (s N, n), optional
        Inputs of the steps.

    Returns
    -------
    model : LinearGaussian
        G^s and sum_j G^j Gamma_w G^j'. Noise of r patterns becomes one of s r patterns while s r < n.
    f : (N, n) or None
        sum_j G^{s-1-j} f_j.
    """
    if substeps < 1:
        raise InvalidInput(f"compose: substeps = {substeps}; must be >= 1.")
    G, n = model.G, model.states
    noise: Array | PatternNoise = model.process_noise
    power = np.linalg.matrix_power(G, substeps)
    if isinstance(noise, PatternNoise) and substeps * noise.patterns.shape[1] < n:
        parts = [noise.patterns]
        for _ in range(substeps - 1):
            parts.append(G @ parts[-1])
        noise = PatternNoise(
            np.concatenate(parts, axis=1), np.kron(np.eye(substeps), noise.covariance).astype(float)
        )
    else:
        total = step = model.Gamma_w
        for _ in range(substeps - 1):
            total = _engine.congruence(G, total, step)
        noise = total
    composed = replace(model, G=power, process_noise=noise)
    if f is None:
        return composed, None
    inputs = checked_matrix(f, "compose", "f", (None, n))
    if len(inputs) % substeps:
        raise InvalidInput(
            f"compose: f has {len(inputs)} rows; must be a multiple of substeps = {substeps}: one per step."
        )
    steps = inputs.reshape(-1, substeps, n)
    out = steps[:, 0]
    for j in range(1, substeps):
        out = out @ G.T + steps[:, j]
    return composed, np.ascontiguousarray(out)


def frame_difference(
    model: LinearGaussian, displacement: ArrayLike, observation: ArrayLike, Gamma_v: ArrayLike
) -> LinearGaussian:
    """y_k = O (D z_k - D z_{k-1}) + v: optical flow is the displacement between two frames.

    The state is augmented with D z of the previous frame, (z_k, D z_{k-1}). Inputs get q more zero columns.

    Parameters
    ----------
    model : LinearGaussian
        The model from frame to frame; its H and Gamma_v are replaced.
    displacement : (q, n)
        D, the observed displacements as a function of the state.
    observation : (p, q)
        O, e.g. pixels per metre and camera directions.
    Gamma_v : (p, p) or (p,)
    """
    n = model.states
    D = checked_matrix(displacement, "frame_difference", "displacement", (None, n))
    q = len(D)
    O_ = checked_matrix(observation, "frame_difference", "observation", (None, q))
    noise = model.process_noise
    if isinstance(noise, PatternNoise):
        patterns = np.concatenate([noise.patterns, np.zeros((q, noise.patterns.shape[1]))])
        noise = PatternNoise(patterns, noise.covariance)
    else:
        noise = np.pad(noise, (0, q))
    return LinearGaussian(
        G=np.block([[model.G, np.zeros((n, q))], [D, np.zeros((q, q))]]),
        H=np.concatenate([O_ @ D, -O_], axis=1),
        process_noise=noise,
        Gamma_v=np.asarray(Gamma_v, dtype=float),
        m0=np.concatenate([model.m0, np.zeros(q)]),
        P0=np.pad(model.P0, (0, q)),
    )
