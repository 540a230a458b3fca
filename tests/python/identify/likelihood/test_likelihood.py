"""The marginal likelihood against the joint Gaussian, a Kalman filter, and differences of itself."""

from __future__ import annotations

import math
from typing import Any, Literal

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import optimize, sparse

import plica
from layered_block import (
    STEP,
    drive,
    layered_mesh,
    layered_model,
    layered_scene,
    patterns,
    points,
    simulated,
    whole,
)
from plica import _engine
from plica.identify import MarginalLikelihood, Noise, SurfacePoints, TissueParameter, estimate, log_prior
from plica.identify.likelihood.noise_levels import profiled
from plica.runs.build import fixed_components
from plica.runs.materials import materials_of

NAMES: list[Any] = ["cover.E", "ligament.mu_fibre", "cover.viscosity"]
FRAMES = 10


def recorded(rng: np.random.Generator, **forcing: Any) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Flow with a missing frame and missing points, and its sd."""
    flow = simulated(layered_model(NAMES, np.ones((FRAMES, 12, 2)), **forcing), rng, collision=400.0)
    flow[4] = np.nan
    flow[6, 2:5] = np.nan
    return flow, rng.uniform(0.05, 0.2, (1, 12, 2))


def with_collision(collides: Literal["none", "held", "estimated"]) -> dict[str, Any]:
    if collides == "none":
        return {}
    closed = np.zeros(FRAMES, dtype=bool)
    closed[3:5] = closed[8] = True
    return {
        "closed": closed,
        "collision": patterns(layered_mesh())[:, 1:],
        "collision_sd": 300.0 if collides == "held" else None,
    }


@pytest.mark.parametrize("collides", ["none", "held", "estimated"])
@pytest.mark.parametrize("noise", [None, Noise(30.0, 0.9, 200.0)])
def test_the_likelihood_is_that_of_the_joint_gaussian(noise: Noise | None, collides: Any) -> None:
    rng = np.random.default_rng(1)
    flow, sd = recorded(rng, **with_collision(collides))
    model = layered_model(
        NAMES, flow, sd=sd, noise=np.array([1.0, 2.0]), gain_sd=0.5, **with_collision(collides)
    )
    likelihood = MarginalLikelihood(model, noise)
    x = likelihood.prior_mean + 0.1 * rng.normal(size=4)
    at = likelihood.evaluate(x)
    assert likelihood.value(x) == at.value
    T = whole(at.responses.lags[0])
    Q = np.zeros((FRAMES, model.patterns.shape[1]))
    Q[:, :2] = (at.noise.pressure * np.array([1.0, 2.0])) ** 2
    if collides != "none":
        Q[[3, 4, 8], 2] = (300 if collides == "held" else at.noise.collision) ** 2
    weights = model.observation.weights.ravel()
    there = weights > 0
    error = (model.observation.rows - math.exp(x[-1]) * at.responses.mean[0]).ravel()[there]
    covariance = ((T * Q.ravel()) @ T.T)[np.ix_(there, there)] + np.diag(at.noise.flow**2 / weights[there])
    logdet = np.linalg.slogdet(covariance)[1]
    joint = -0.5 * (len(error) * math.log(2 * math.pi) + logdet + error @ np.linalg.solve(covariance, error))
    assert at.value == pytest.approx(joint, rel=1e-10)


def test_the_likelihood_is_that_of_a_kalman_filter() -> None:
    """The state (u, v, a) of every free unknown and the last frame's u, marched with dense G and F."""
    rng = np.random.default_rng(2)
    mesh = layered_mesh((1, 2, 3), order=1)
    seen = SurfacePoints.at_nodes(np.flatnonzero(on_top(mesh)))
    flow = simulated(layered_model(["cover.E"], np.ones((6, 2, 2)), mesh, seen=seen), rng, pressure=80.0)
    flow[2, 1] = np.nan
    flow[4] = np.nan
    model = layered_model(["cover.E"], flow, mesh, seen=seen)
    noise = Noise(40.0, 1.1)
    value = MarginalLikelihood(model, noise).value(model.tissue.prior_mean)
    assert value == pytest.approx(kalman(model, mesh, noise), rel=1e-8)


def on_top(mesh: _engine.TetMesh) -> NDArray[np.bool_]:
    x = np.asarray(mesh.points)
    return (x[:, 2] > x[:, 2].max() - 1e-9) & (x[:, 1] > 1e-3) & (x[:, 1] < 5e-3)


def kalman(model: Any, mesh: _engine.TetMesh, noise: Noise) -> float:
    """The innovations' log-likelihood, of the HHT step as docs/identification.md has it."""
    scene = layered_scene()
    free = ~fixed_components(scene, mesh).ravel()
    assembly = _engine.Assembly(mesh, *materials_of(scene, mesh))
    M, C, K = (
        sparse.csr_array(part()).toarray()[np.ix_(free, free)]
        for part in (assembly.mass, assembly.viscosity, assembly.stiffness)
    )
    al, h, n = -0.3, STEP, int(free.sum())
    beta, gamma = (1 - al) ** 2 / 4, 0.5 - al
    A = M + (1 + al) * gamma * h * C + (1 + al) * beta * h**2 * K
    Bu = -np.linalg.solve(A, K)
    Bv = -np.linalg.solve(A, C + (1 + al) * h * K)
    Ba = -(1 + al) * np.linalg.solve(A, (1 - gamma) * h * C + h**2 * (0.5 - beta) * K)
    one = np.eye(n)
    G = np.block(
        [
            [
                one + beta * h**2 * Bu,
                h * one + beta * h**2 * Bv,
                h**2 * (0.5 - beta) * one + beta * h**2 * Ba,
            ],
            [gamma * h * Bu, one + gamma * h * Bv, (1 - gamma) * h * one + gamma * h * Ba],
            [Bu, Bv, Ba],
        ]
    )
    b = np.linalg.solve(A, patterns(mesh)[free])
    F = np.vstack([beta * h**2 * b, gamma * h * b, b])
    unknowns, camera = model.observation.displacements()
    place = np.full(len(free), -1)
    place[free] = np.arange(n)
    H = np.zeros((camera.shape[0], n))
    for column, unknown in enumerate(unknowns):
        if free[unknown]:
            H[:, place[unknown]] = camera[:, [column]].toarray()[:, 0]
    waves = drive(len(model.observation.rows))
    frame_map, held = np.eye(3 * n), np.zeros((3 * n, 2))
    for _ in range(5):
        frame_map, held = G @ frame_map, G @ held + F
    z, P, value = np.zeros(3 * n), np.zeros((3 * n, 3 * n)), 0.0
    observe = np.hstack([H, np.zeros((len(H), 2 * n)), -H])
    for k, (rows, weights) in enumerate(zip(model.observation.rows, model.observation.weights, strict=True)):
        last = z[:n]
        transition = np.vstack([frame_map, np.eye(n, 3 * n)])
        inputs = np.vstack([held, np.zeros((n, 2))])
        for step in range(5):
            z = G @ z + F @ waves[5 * k + step]
        z = np.concatenate([z, last])
        P = transition @ P @ transition.T + noise.pressure**2 * inputs @ inputs.T
        there = weights > 0
        if there.any():
            seen = observe[there]
            S = seen @ P @ seen.T + np.diag(noise.flow**2 / weights[there])
            e = rows[there] - seen @ z
            gain = np.linalg.solve(S, seen @ P).T
            z, P = z + gain @ e, P - gain @ (seen @ P)
            value -= 0.5 * (
                len(e) * math.log(2 * math.pi) + np.linalg.slogdet(S)[1] + e @ np.linalg.solve(S, e)
            )
        z, P = z[: 3 * n], 0.5 * (P + P.T)[: 3 * n, : 3 * n]
    return value


@pytest.mark.parametrize("collides", ["none", "held", "estimated"])
@pytest.mark.parametrize("noise", [None, Noise(30.0, 0.9, 200.0)])
def test_the_gradient_is_a_central_difference(noise: Noise | None, collides: Any) -> None:
    rng = np.random.default_rng(4)
    flow, sd = recorded(rng, **with_collision(collides))
    model = layered_model(NAMES, flow, sd=sd, gain_sd=0.5, **with_collision(collides))
    likelihood = MarginalLikelihood(model, noise)
    x, h = likelihood.prior_mean + 0.1 * rng.normal(size=4), 1e-3
    value, gradient = likelihood.value_and_gradient(x)
    assert value == likelihood.evaluate(x).value + log_prior(likelihood, x)

    def density(shift: NDArray[np.float64]) -> float:
        return likelihood.value(x + shift) + log_prior(likelihood, x + shift)

    for j in range(4):
        e = h * np.eye(4)[j]
        a, b, c, d = (density(k * e) for k in (-2, -1, 1, 2))
        difference = (a - 8 * b + 8 * c - d) / (12 * h)
        assert abs(difference) > 1e-2
        assert abs(gradient[j] - difference) < 1e-6 * abs(gradient).max()


@pytest.mark.parametrize("collides", ["none", "held", "estimated"])
def test_the_information_is_that_of_the_joint_gaussian(collides: Any) -> None:
    """dmu' S^-1 dmu + tr(S^-1 dS S^-1 dS) / 2 with the noise levels among the parameters, then eliminated."""
    rng = np.random.default_rng(6)
    flow, sd = recorded(rng, **with_collision(collides))
    model = layered_model(NAMES, flow, sd=sd, **with_collision(collides))
    likelihood = MarginalLikelihood(model)
    at = likelihood.evaluate(likelihood.prior_mean + 0.05)
    weights = model.observation.weights.ravel()
    there = weights > 0
    T = [whole(lags)[there] for lags in at.responses.lags]
    ratio = (at.noise.pressure / at.noise.flow) ** 2
    q = model.patterns.shape[1]
    Qp, Qc = np.zeros((FRAMES, q)), np.zeros((FRAMES, q))
    Qp[:, :2] = ratio
    if collides != "none":
        Qc[[3, 4, 8], 2] = ((300.0 if collides == "held" else at.noise.collision) / at.noise.flow) ** 2
    Q = (Qp + Qc).ravel()
    R = np.diag(1 / weights[there])
    inverse = np.linalg.inv(at.noise.flow**2 * (R + (T[0] * Q) @ T[0].T))
    moves = [at.noise.flow**2 * ((D * Q) @ T[0].T + (T[0] * Q) @ D.T) for D in T[1:]]
    levels = [Qp] if collides != "estimated" else [Qp, Qc]
    moves += [at.noise.flow**2 * (T[0] * level.ravel()) @ T[0].T for level in levels]
    known = at.noise.flow**2 * (T[0] * Qc.ravel()) @ T[0].T  # a sd in Pa that does not grow with the flow's
    moves += [np.linalg.inv(inverse) - (known if collides == "held" else 0)]
    means = [d.ravel()[there] for d in at.responses.mean[1:]] + [np.zeros(there.sum())] * (1 + len(levels))
    whole_information = np.array(
        [
            [
                m @ inverse @ k + 0.5 * np.trace(inverse @ A @ inverse @ B)
                for k, B in zip(means, moves, strict=True)
            ]
            for m, A in zip(means, moves, strict=True)
        ]
    )
    cross = whole_information[:3, 3:]
    reduced = whole_information[:3, :3] - cross @ np.linalg.solve(whole_information[3:, 3:], cross.T)
    assert np.allclose(at.information, reduced, rtol=1e-8, atol=1e-8 * reduced.max())
    assert np.linalg.eigvalsh(at.information)[0] > 0


@pytest.mark.parametrize("collides", ["none", "held", "estimated"])
def test_the_profiled_noise_is_the_best(collides: Any) -> None:
    rng = np.random.default_rng(7)
    model = layered_model(NAMES, recorded(rng, **with_collision(collides))[0], **with_collision(collides))
    likelihood = MarginalLikelihood(model)
    best = likelihood.evaluate(likelihood.prior_mean)
    assert best.noise.pressure > 1
    if collides == "held":
        assert best.noise.collision == 300.0
    for pressure, flow, collision in (
        (1.01, 1, 1),
        (0.99, 1, 1),
        (1, 1.01, 1),
        (1, 0.99, 1),
        (1, 1, 1.01),
        (1, 1, 0.99),
    ):
        if collision != 1 and collides != "estimated":
            continue
        there = Noise(
            best.noise.pressure * pressure, best.noise.flow * flow, best.noise.collision * collision
        )
        assert MarginalLikelihood(model, there).value(best.point) < best.value


def test_a_level_at_a_bound_of_its_search_is_reported() -> None:
    """Of inputs that no residual points at, and of inputs that take all of it."""
    gram, count = np.diag([1.0, 2.0, 4.0]), 30
    none = profiled(gram, np.zeros(3), 5.0, count, (3, 0, 0), None)
    assert (none.at_least, none.at_most) == (("pressure",), ())
    assert "lower bound of its search: the recording shows none of them" in none.sentences()[0]
    pushed = np.array([1.0, -2.0, 3.0])
    whole_of_it = float(pushed @ np.linalg.solve(gram, pushed))
    all_of_it = profiled(gram, pushed, whole_of_it * (1 + 1e-15), count, (3, 0, 0), None)
    assert (all_of_it.at_least, all_of_it.at_most) == ((), ("pressure",))
    assert "upper bound of its search" in all_of_it.sentences()[0]
    plain = profiled(gram, pushed, whole_of_it + 10.0, count, (3, 0, 0), None)
    assert plain.sentences() == []
    beside = profiled(gram, pushed * [1, 1, 0], 20.0, count, (2, 1, 0), None)
    assert beside.at_least == ("collision",)
    assert "forces of closed frames" in beside.sentences()[0]
    assert profiled(gram, 0 * pushed, 20.0, count, (2, 1, 0), 1.0).at_least == ("pressure",)


def test_a_held_level_of_collisions_is_in_pascal() -> None:
    """The level that is found is, held, the one that is found, and the likelihood the same; in px and Pa."""
    rng = np.random.default_rng(7)
    given = with_collision("estimated")
    flow = recorded(rng, **given)[0]
    free = MarginalLikelihood(layered_model(NAMES, flow, sd=0.02, **given))
    x = free.prior_mean
    found = free.evaluate(x)
    assert found.noise.flow > 2  # times as stated
    given["collision_sd"] = found.noise.collision
    held = MarginalLikelihood(layered_model(NAMES, flow, sd=0.02, **given)).evaluate(x)
    assert held.value == pytest.approx(found.value, rel=1e-9)
    for name in ("pressure", "flow", "collision"):
        assert getattr(held.noise, name) == pytest.approx(getattr(found.noise, name), rel=1e-9)
    given["collision_sd"] *= 1.5
    assert MarginalLikelihood(layered_model(NAMES, flow, sd=0.02, **given)).evaluate(x).value < held.value


def test_an_optimiser_of_the_world_finds_the_same_tissue() -> None:
    rng = np.random.default_rng(8)
    likelihood = MarginalLikelihood(layered_model(NAMES, recorded(rng)[0]))
    found = estimate(likelihood)
    sd = found.sd

    def cost(scaled: NDArray[np.float64]) -> tuple[float, NDArray[np.float64]]:
        value, gradient = likelihood.value_and_gradient(found.prior_mean + scaled * sd)
        return -value, -gradient * sd

    end = optimize.minimize(cost, np.zeros(3), jac=True, method="BFGS", options={"gtol": 1e-3})
    assert np.allclose(found.prior_mean + end.x * sd, found.mean, rtol=0, atol=0.05 * sd.min())


def test_a_tissue_that_stores_no_energy_is_infinitely_improbable() -> None:
    likelihood = MarginalLikelihood(layered_model(["cover.nu"], np.ones((4, 12, 2))))
    value, gradient = likelihood.value_and_gradient([math.log(0.99)])
    assert value == -math.inf
    assert np.isnan(gradient).all()
    with pytest.raises(plica.InvalidInput, match="x must be 1 finite"):
        likelihood.value_and_gradient([math.nan])


def test_tied_targets_keep_their_ratio() -> None:
    tied = TissueParameter(("cover.viscosity", "body.viscosity"), name="viscosity")
    model = layered_model([tied], np.ones((4, 12, 2)))
    made = model.tissue.materials(np.log([0.28]))
    assert [m.viscosity for m in made] == pytest.approx([0.7, 0.35, 0.28])
    assert points(layered_mesh()).nodes.shape == (12, 6)


def test_the_gradient_by_the_camera_s_tilt_is_a_central_difference() -> None:
    rng = np.random.default_rng(9)
    flow, _ = recorded(rng)
    model = layered_model(NAMES, flow, gain_sd=0.5, tilt_sd=6.0)
    likelihood = MarginalLikelihood(model)
    assert likelihood.names[3:] == ("tilt", "lean", "gain")
    x, h = likelihood.prior_mean + 0.1 * rng.normal(size=6), 1e-3
    gradient = likelihood.evaluate(x).gradient
    for j in (3, 4):
        e = h * np.eye(6)[j]
        a, b, c, d = (likelihood.value(x + k * e) for k in (-2, -1, 1, 2))
        difference = (a - 8 * b + 8 * c - d) / (12 * h)
        assert abs(difference) > 1e-2
        assert abs(gradient[j] - difference) < 1e-6 * abs(gradient).max()
