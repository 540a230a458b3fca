"""The likelihood of a recording as a function of the tissue, and the tissue that it finds."""

from __future__ import annotations

from collections.abc import Iterator
from math import exp, log, pi

import numpy as np
from scipy import sparse

from plica import _engine
from plica.identify import MarginalLikelihood, Noise, estimate
from plica.runs.build import fixed_components
from plica.runs.materials import materials_of
from plica.verify.case import Case, Check, zero
from plica.verify.identification.recorded import (
    FRAMES,
    NAMES,
    UNKNOWN,
    layered,
    motion_model,
    prior,
    recorded,
    scene,
    stepped,
)

__all__ = ["CASES"]


def affine() -> Iterator[Check]:
    """K as a sum of matrices times the law's coefficients."""
    mesh, of = layered(), scene()
    body = materials_of(of, mesh)
    tissue = _engine.AffineTissue(mesh, *body, fixed_components(of, mesh))
    assembly = _engine.Assembly(mesh, *body)
    parts = {
        "stiffness": (
            tissue.stiffness(np.array([_engine.stiffness_coefficients(m) for m in body[0]])),
            assembly.stiffness(),
        ),
        "viscosity": (tissue.viscosity(np.array([m.viscosity for m in body[0]])), assembly.viscosity()),
    }
    for name, (made, given) in parts.items():
        one, other = (sparse.csr_array(part) for part in (made, given))
        yield zero(
            name=name,
            quantity=f"largest difference of an entry of the {name} matrix, over the largest",
            value=float(abs(one - other).max() / abs(other).max()),
            tolerance=1e-13,
            because="round-off of a sum over the cells of a node",
        )


def response() -> Iterator[Check]:
    """The mean flow from impulse responses."""
    mesh = layered()
    model = motion_model(mesh, np.ones((FRAMES, 12, 2)))
    mean = np.asarray(model.responses(prior(mesh), derivatives=False).mean[0]).reshape(FRAMES, -1)
    exact = stepped(mesh)
    k = np.unravel_index(int(np.argmax(np.abs(mean - exact))), mean.shape)
    yield Check(
        name="flow",
        quantity="flow of the point and frame that is furthest off",
        unit="px/frame",
        value=float(mean[k]),
        reference=float(exact[k]),
        tolerance=1e-9 * float(np.abs(exact).max()),
        because="150 solves of the engine to 1e-13, differences of frames, over the largest flow",
        of="unit",
    )


def joint() -> Iterator[Check]:
    """log p(y) with the whole covariance T Q T' + R."""
    mesh = layered()
    model = recorded(mesh, stepped(mesh))
    noise = Noise(UNKNOWN, 1.1)
    x = prior(mesh) + 0.1 * np.array([1.0, -0.5, 0.7])
    at = MarginalLikelihood(model, noise).evaluate(x)
    lags = np.asarray(at.responses.lags[0])  # (N, rows, inputs), by the frames since
    frames, rows, inputs = lags.shape
    T = np.zeros((frames, rows, frames, inputs))
    for k in range(frames):
        for j in range(k + 1):
            T[k, :, j] = lags[k - j]
    flat = T.reshape(frames * rows, frames * inputs)
    weights = model.observation.weights.ravel()
    there = weights > 0
    S = (noise.pressure**2 * flat @ flat.T)[np.ix_(there, there)] + np.diag(noise.flow**2 / weights[there])
    e = (model.observation.rows - np.asarray(at.responses.mean[0])).ravel()[there]
    exact = -0.5 * (len(e) * log(2 * pi) + np.linalg.slogdet(S)[1] + e @ np.linalg.solve(S, e))
    yield Check(
        name="value",
        quantity=f"log-likelihood of {FRAMES} frames of twelve points, some of them lost",
        value=at.value,
        reference=float(exact),
        tolerance=1e-10,
        because="round-off of a covariance with a condition number below 1e5",
    )


def gradient() -> Iterator[Check]:
    """Four points about x, the noise levels profiled anew at each."""
    mesh = layered()
    likelihood = MarginalLikelihood(recorded(mesh, stepped(mesh)))
    x, h = likelihood.prior_mean + 0.1 * np.array([1.0, -0.5, 0.7]), 1e-3
    found = likelihood.evaluate(x).gradient
    for j, name in enumerate(NAMES):
        step = h * np.eye(len(x))[j]
        a, b, c, d = (likelihood.value(x + k * step) for k in (-2, -1, 1, 2))
        yield Check(
            name=name,
            quantity=f"derivative of the log-likelihood by log {name}",
            value=float(found[j]),
            reference=(a - 8 * b + 8 * c - d) / (12 * h),
            tolerance=1e-6 * float(np.abs(found).max()),
            because="the difference's own error, h^4 / 30 of the fifth derivative, and round-off "
            "1e-13 |l| / h",
            of="unit",
        )


def planted() -> Iterator[Check]:
    """The tissue that is most probable, from a start that is wrong by a third."""
    mesh = layered()
    likelihood = MarginalLikelihood(recorded(mesh, stepped(mesh)))
    truth = prior(mesh)
    found = estimate(likelihood, truth + 0.3)
    for j, name in enumerate(NAMES):
        yield Check(
            name=name,
            quantity=f"{name}, most probable",
            unit=found.units[j],
            value=exp(float(found.mean[j])),
            reference=exp(float(truth[j])),
            tolerance=exp(3 * float(found.sd[j])) - 1,
            because="three standard deviations of the posterior, 0.997 of a Gaussian",
        )


CASES = (
    Case(
        "affine-form",
        "The matrices that the estimator takes apart by parameters are those of direct assembly.",
        "direct assembly",
        affine,
    ),
    Case(
        "responses",
        "The motion that the estimator superposes from impulses is the one that the engine steps through.",
        "150 steps of the engine",
        response,
    ),
    Case(
        "likelihood",
        "The marginal likelihood of a recording is that of the joint Gaussian of all its flow.",
        "dense covariance of the flow",
        joint,
    ),
    Case(
        "gradient",
        "The gradient of the likelihood by the tissue is its difference quotient.",
        "central differences of fourth order",
        gradient,
    ),
    Case(
        "planted-tissue",
        "From flow with noise and unknown pressures comes the tissue that made it, within the stated "
        "uncertainty.",
        "the tissue with which the engine made the flow",
        planted,
    ),
)
