"""Estimates: the tissue is recovered, intervals contain it, and what is not determined gives a warning."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import stats

import plica
from layered_block import (
    CAMERA,
    SIZE,
    drive,
    layered_mesh,
    layered_model,
    layered_scene,
    patterns,
    points,
    shown,
    simulated,
    whole,
)
from plica import _engine
from plica.identify import (
    Evaluation,
    Forcing,
    MarginalLikelihood,
    MotionModel,
    Noise,
    Observation,
    Posterior,
    Prior,
    Scoring,
    SurfacePoints,
    TissueParameter,
    estimate,
    posterior_table,
    posterior_warnings,
)
from plica.identify.likelihood.residuals import residual_test
from plica.scene.mesh.changed import changed_mesh

VISCOSITY = TissueParameter(("cover.viscosity", "ligament.viscosity", "body.viscosity"), name="viscosity")
NAMES: list[Any] = [VISCOSITY, "cover.E", "cover.mu_fibre", "ligament.mu_fibre"]
FRAMES = 40


def offset(parameters: list[Any], by: NDArray[np.float64]) -> list[TissueParameter]:
    """The same with prior medians off the scene's values by exp(by)."""
    model = layered_model(parameters, np.ones((2, 12, 2)))
    return [
        TissueParameter(p.targets, Prior(float(np.exp(mean + off)), 0.5), p.name)
        for p, mean, off in zip(model.tissue.parameters, model.tissue.prior_mean, by, strict=True)
    ]


@pytest.fixture(scope="module")
def draws() -> tuple[NDArray[np.float64], list[Posterior]]:
    """True log theta and twelve posteriors, each from a prior of its own."""
    truth = layered_model(NAMES, np.ones((FRAMES, 12, 2)))
    found = []
    for seed in range(12):
        rng = np.random.default_rng(seed)
        flow = simulated(truth, rng, pressure=20.0)
        model = layered_model(offset(NAMES, rng.normal(0, 0.3, 4)), flow, gain_sd=0.3)
        found.append(estimate(MarginalLikelihood(model)))
    return np.append(truth.tissue.prior_mean, 0.0), found


@pytest.mark.slow
def test_the_tissue_comes_back(draws: tuple[NDArray[np.float64], list[Posterior]]) -> None:
    """Errors over their sd are standard normal: 60 numbers, of which 95 % intervals hold all but a few.

    Their mean square lies in these bounds with 99.9 % probability, the bound on coverage is that of 60 draws
    of 0.95 at 0.1 %. Both are for independent numbers; the five of one draw are not quite.
    """
    truth, found = draws
    scores = np.array([(p.mean - truth) / p.sd for p in found])
    low, high = stats.chi2.ppf([0.0005, 0.9995], scores.size) / scores.size
    assert low < np.mean(scores**2) < high
    held = np.sum(np.abs(scores) < 1.959964)
    assert held >= stats.binom.ppf(0.001, scores.size, 0.95)
    sd = np.median([p.sd for p in found], axis=0)
    error = np.abs(np.mean([p.mean - truth for p in found], axis=0))
    assert (error < 4 * sd / np.sqrt(len(found))).all()  # no bias but noise
    assert (sd[:3] < 0.1).all()
    assert np.median([p.iterations for p in found]) <= 6  # single ones take up to ten


@pytest.mark.slow
def test_the_residuals_are_white_where_the_model_holds(
    draws: tuple[NDArray[np.float64], list[Posterior]],
) -> None:
    scores = np.array([(r.in_time, r.in_space, r.tails, r.level) for r in (p.residuals for p in draws[1])])
    assert all(p.residuals.passed for p in draws[1])
    low, high = stats.chi2.ppf([0.0005, 0.9995], scores.size) / scores.size
    assert low < np.mean(scores**2) < high
    assert all(not p.residuals.sentences() for p in draws[1])


@pytest.mark.slow
def test_intervals_correlation_and_identifiability_fit_together(
    draws: tuple[NDArray[np.float64], list[Posterior]],
) -> None:
    p = draws[1][0]
    low, high = p.interval().T
    assert np.allclose(np.log(high / low), 2 * 1.959964 * p.sd, rtol=1e-6)
    assert np.allclose(np.sqrt(low * high), p.median)
    assert np.allclose(np.diag(p.correlation), 1)
    assert np.linalg.eigvalsh(p.correlation)[0] > 0
    weak = p.weakest_direction / p.prior_sd
    assert weak @ (p.prior_sd[:, None] * p.information * p.prior_sd) @ weak == pytest.approx(
        p.information_eigenvalues[0]
    )
    assert "cover.E" in posterior_table(p)
    with pytest.raises(plica.InvalidInput, match=r"level = 1; must be in \(0, 1\)"):
        p.interval(1.0)


def test_whitened_residuals_are_the_cholesky_factor_s() -> None:
    """Frame by frame is the whole vector over the whole factor."""
    rng = np.random.default_rng(3)
    flow = simulated(layered_model(["cover.E"], np.ones((6, 12, 2))), rng)
    flow[2] = np.nan
    flow[3, 4] = np.nan
    model = layered_model(["cover.E"], flow, sd=rng.uniform(0.05, 0.2, (1, 12, 2)))
    likelihood = MarginalLikelihood(model, Noise(80.0, 1.2))
    at = likelihood.evaluate(likelihood.prior_mean)
    T = whole(at.responses.lags[0])
    weights = model.observation.weights.ravel()
    there = weights > 0
    covariance = 80.0**2 * (T @ T.T)[np.ix_(there, there)] + np.diag(1.2**2 / weights[there])
    error = (model.observation.rows - at.responses.mean[0]).ravel()[there]
    expected = np.linalg.solve(np.linalg.cholesky(covariance), error)
    z = likelihood.whitened(at).ravel()
    assert np.isnan(z[~there]).all()
    assert np.allclose(z[there], expected, rtol=1e-8, atol=1e-8)


def test_smooth_flow_noise_fails_the_residual_test() -> None:
    rng = np.random.default_rng(5)
    flow = simulated(layered_model(NAMES, np.ones((FRAMES, 12, 2))), rng, pressure=20.0, flow=0.01)
    common = rng.normal(0, 0.1, (FRAMES, 1, 3, 2))  # one error for the four points of a column
    flow += np.broadcast_to(common, (FRAMES, 4, 3, 2)).reshape(FRAMES, 12, 2)
    likelihood = MarginalLikelihood(layered_model(NAMES, flow))
    test = likelihood.residual_test(likelihood.evaluate(likelihood.prior_mean))
    assert not test.passed
    assert abs(test.in_space) > 3.3
    assert any("neighbouring points" in sentence for sentence in test.sentences())


def test_a_parameter_that_nothing_depends_on_is_named() -> None:
    """A second block that no pressure reaches."""
    both = _engine.combine(
        _engine.block_mesh(size=SIZE, divisions=(1, 2, 2)),
        _engine.block_mesh(corner=(0.02, 0, 0), size=SIZE, divisions=(1, 1, 1)),
    )
    x, cells = np.asarray(both.points), np.asarray(both.cells)
    far = x[cells].mean(axis=1)[:, 0] > 0.01
    mesh = changed_mesh(both, cell_layer=far.astype(np.int32), layer_names=["cover", "body"])
    scene = plica.Scene(
        plica.Block(size=SIZE),
        {"cover": plica.Tissue(E=1e3, nu=0.3), "body": plica.Tissue(E=2e3, nu=0.3)},
        time=plica.Stepping(step=50e-6, duration=50e-6),
        supports=plica.Supports(fixed=("a.z_min", "b.z_min")),
    )
    force = np.ascontiguousarray(Forcing.on_surface(mesh, "a.x_max", [0, 3e-3]))
    seen = SurfacePoints.seen(
        mesh, "a.z_max", CAMERA, shown(np.array([[2e-3, 3e-3, 3e-3], [3e-3, 3e-3, 3e-3]]))
    )
    flow = np.random.default_rng(0).normal(size=(4, 2, 2))
    model = MotionModel(
        scene,
        ["cover.E", "body.E"],
        Observation(seen, CAMERA, flow),
        Forcing(force, np.ones((20, 2))),
        mesh=mesh,
    )
    with pytest.raises(plica.InvalidInput, match=r'the data do not depend on "body\.E"'):
        estimate(MarginalLikelihood(model))


@pytest.mark.slow
def test_the_shift_of_a_finer_mesh_widens_the_posterior_and_belies_the_sd(
    draws: tuple[NDArray[np.float64], list[Posterior]],
) -> None:
    coarse = draws[1][0]
    sd = np.sqrt(np.diag(coarse.statistical_covariance))
    shift = np.array([3.0, 0.1, 0.0, -0.2, 0.0]) * sd
    both = coarse.refined_by(replace(coarse, mean=coarse.mean + shift))
    assert np.allclose(both.sd**2, sd**2 + shift**2)
    assert both.shift_in_sd == pytest.approx(shift / sd)
    assert both.belied.tolist() == [True, False, False, False, False]
    assert posterior_table(both).splitlines()[1].count("refused") == 1
    assert posterior_table(both).count("refused") == 1
    assert any("+3.0 of its sd" in text for text in posterior_warnings(both))
    assert any("Only one mesh" in text for text in posterior_warnings(coarse))
    assert not any("Only one mesh" in text for text in posterior_warnings(both))


@pytest.mark.slow
def test_unknown_forces_in_closed_frames_stand_for_collisions() -> None:
    """Forces of 800 Pa on the medial face in six frames that are called closed."""
    mesh, rng = layered_mesh(), np.random.default_rng(11)
    medial = patterns(mesh)[:, 1:]
    closed = np.zeros(FRAMES, dtype=bool)
    closed[10:13] = closed[26:29] = True
    given: dict[str, Any] = {"closed": closed, "collision": medial}
    truth = layered_model(NAMES, np.ones((FRAMES, 12, 2)), mesh, **given)
    there = truth.responses(truth.tissue.prior_mean, derivatives=False)
    push = np.zeros((FRAMES, 3))
    push[closed, 2] = 800 * rng.uniform(0.5, 1.5, 6)
    pushed = np.asarray(_engine.toeplitz_product(there.lags[0], push.reshape(-1, 1))).reshape(FRAMES, 12, 2)
    flow = simulated(truth, rng, pressure=5.0) + pushed
    ignored = estimate(MarginalLikelihood(layered_model(NAMES, flow, mesh)))
    mended = estimate(MarginalLikelihood(layered_model(NAMES, flow, mesh, **given)))
    score = (mended.mean - truth.tissue.prior_mean) / mended.sd
    assert np.abs(score).max() < 3
    assert (mended.sd[:3] < ignored.sd[:3]).all()  # unknown pressures take the blame, and say so
    assert mended.log_likelihood > ignored.log_likelihood + 50
    assert mended.noise.pressure < 0.5 * ignored.noise.pressure


def test_a_run_up_of_missing_frames_stands_for_an_unknown_beginning() -> None:
    """Seen from frame 15 on, the drive unknown: pressures of the frames before bring the model into
    motion."""
    rng = np.random.default_rng(12)
    names: list[Any] = [VISCOSITY, "cover.mu_fibre"]
    truth = layered_model(names, np.ones((FRAMES, 12, 2)), drive=None)
    flow = simulated(truth, rng, pressure=200.0)
    flow[:15] = np.nan
    found = estimate(MarginalLikelihood(layered_model(names, flow, drive=None)))
    assert np.abs((found.mean - truth.tissue.prior_mean) / found.sd).max() < 3
    assert (found.sd < 0.2).all()
    assert found.noise.pressure == pytest.approx(200, rel=0.2)


def test_a_scene_with_contact_is_refused(colliding: plica.Scene) -> None:
    observation = Observation(SurfacePoints.at_nodes([0]), CAMERA, np.ones((4, 1, 2)))
    with pytest.raises(
        plica.InvalidInput,
        match=r"contact, initial are given; must be left out\. With contact the motion is not",
    ):
        MotionModel(colliding, ["a.E"], observation, Forcing(np.ones((3, 1))))


def model_with(**changes: Any) -> MotionModel:
    mesh = layered_mesh()
    given: dict[str, Any] = {
        "scene": layered_scene(),
        "parameters": ["cover.E"],
        "flow": np.ones((4, 12, 2)),
        "forcing": {},
        "observation": {},
    } | changes
    observation = Observation(points(mesh), CAMERA, given["flow"], **given["observation"])
    forcing = Forcing(**{"patterns": patterns(mesh), "drive": drive(4)} | given["forcing"])
    return MotionModel(given["scene"], given["parameters"], observation, forcing, mesh=mesh)


@pytest.mark.parametrize(
    ("changes", "text"),
    [
        ({"parameters": []}, "number of parameters = 0; must be >= 1"),
        ({"parameters": ["cover"]}, 'target = "cover"; must be a layer and a field'),
        ({"parameters": ["cover.density"]}, 'target = "cover.density"; must be a layer and a field'),
        ({"parameters": ["skin.E"]}, 'layer = "skin"; must be'),
        ({"parameters": ["cover.E", "cover.E"]}, 'is set by "cover.E" and by "cover.E"'),
        ({"parameters": ["cover.mu_transverse"]}, '"cover.mu_transverse" is not set in the scene'),
        ({"parameters": ["cover.mu"]}, 'Did you mean "cover.mu_transverse", as in scenes?'),
        ({"flow": np.ones((4, 11, 2))}, r"flow has shape \(4, 11, 2\); must be \(N, 12, 2\)"),
        ({"flow": np.zeros((4, 12, 2))}, "flow is zero everywhere; must show motion"),
        ({"flow": np.full((4, 12, 2), np.nan)}, "every frame of flow is missing"),
        ({"flow": np.full((4, 12, 2), np.inf)}, "must be finite, or nan"),
        ({"observation": {"sd": 0.0}}, "sd must be > 0"),
        ({"observation": {"sd": np.ones(5)}}, "must broadcast to"),
        (
            {"observation": {"frame_rate": 3000.0}},
            r"frame interval / step = 6\.66667; must be a whole number",
        ),
        ({"observation": {"frame_rate": -1.0}}, "frame_rate = -1 Hz; must be > 0"),
        (
            {"observation": {"closed": np.ones(4, dtype=bool)}},
            "frames are closed, but forcing.collision is missing",
        ),
        ({"observation": {"closed": np.ones(3, dtype=bool)}}, "closed must be 4 booleans"),
        ({"forcing": {"drive": drive(5)}}, "drive has 25 steps; must have 20"),
        ({"forcing": {"drive": drive(4)[:, 0]}}, r"drive has shape \(20,\); must have shape \(steps, 2\)"),
        ({"forcing": {"drive": drive(4)[:, :1]}}, r"drive has shape \(20, 1\); must have shape"),
        ({"forcing": {"drive": 1j * drive(4)}}, "drive must be an array of real numbers in Pa"),
        ({"forcing": {"drive": [["0.8 kPa", 0]]}}, "equal length, without units"),
        ({"forcing": {"drive": [[1, 2], [3]]}}, "rows of equal length"),
        ({"forcing": {"drive": drive(4) + np.array([0, np.inf])}}, r"drive\[0, 1\] = inf Pa; must be finite"),
        ({"forcing": {"drive": 1e4 * drive(4)}}, r"must be in \[-100000, 100000\]\. Is the unit right"),
        ({"forcing": {"noise": np.array([1.0, -1.0])}}, "noise must be 2 numbers >= 0"),
        ({"forcing": {"noise": np.zeros(2)}}, "noise is zero in every pattern"),
        ({"forcing": {"gain_sd": -0.1}}, "gain_sd = -0.1; must be >= 0"),
        ({"forcing": {"gain_sd": 0.1, "drive": None}}, "gain_sd is given without the drive"),
        ({"forcing": {"patterns": np.ones((9, 2))}}, "patterns have 9 rows; must have"),
        ({"forcing": {"collision": np.ones((9, 1))}}, r"collision has shape \(9, 1\)"),
        ({"scene": layered_scene(gravity=(0.0, 0.0, -9.8))}, "gravity is given; must be left out"),
        (
            {
                "scene": layered_scene(
                    time=plica.Stepping(
                        step=5e-5, duration=5e-5, scheme=plica.Scheme(newmark=plica.Newmark())
                    )
                )
            },
            "time.scheme must be hht",
        ),
        (
            {"scene": layered_scene(time=plica.Stepping(step=5e-5, duration=5e-5, mass="lumped"))},
            'time.mass = "lumped"; must be "consistent"',
        ),
    ],
)
def test_what_does_not_fit_is_refused(changes: dict[str, Any], text: str) -> None:
    with pytest.raises(plica.InvalidInput, match=text):
        model_with(**changes)


@pytest.mark.parametrize(
    ("make", "text"),
    [
        (lambda: Prior(-1.0), "median = -1; must be > 0"),
        (lambda: Prior(1.0, 0.0), "log_sd = 0; must be > 0"),
        (lambda: model_with(observation={"tilt_sd": -1.0}), r"tilt_sd = -1 degrees; must be in \[0, 45\)"),
        (lambda: Scoring(max_iterations=0), "max_iterations = 0; must be > 0"),
        (lambda: Scoring(starts=2.5), "starts = 2.5; must be a whole number"),
        (lambda: Scoring(starts=19), "starts = 19; must be at most 18"),
        (lambda: Noise(pressure=math.nan), "pressure = nan Pa; must be a number >= 0"),
        (lambda: residual_test(np.full((3, 4), np.nan), np.eye(2)), "none of 12 is a number"),
        (
            lambda: SurfacePoints.seen(layered_mesh(), "z_max", CAMERA, np.array([[-500.0, 0.0]])),
            r"pixels\[0\] = \[-500, 0\] px; must show the surface",
        ),
        (
            lambda: MarginalLikelihood(model_with(), Noise(1.0, 0.0)),
            "noise = 1 Pa, 0, 0 Pa, 0; must",
        ),
    ],
)
def test_parts_that_make_no_sense_are_refused(make: Any, text: str) -> None:
    with pytest.raises(plica.InvalidInput, match=text):
        make()


def test_a_drive_is_what_its_numbers_say() -> None:
    """As a list, of whole numbers or in single precision."""
    whole_numbers = np.round(drive(4)).astype(int)
    given = [whole_numbers.tolist(), whole_numbers, whole_numbers.astype(np.float32)]
    means = [
        model_with(forcing={"drive": one}).responses(np.zeros(1) + np.log(1e3), False).mean for one in given
    ]
    assert np.abs(means[0]).max() > 0
    assert np.array_equal(means[0], means[1])
    assert np.array_equal(means[0], means[2])


def test_an_estimate_that_has_not_converged_says_so() -> None:
    flow = simulated(layered_model(NAMES, np.ones((10, 12, 2))), np.random.default_rng(1))
    far = offset(NAMES, np.array([1.0, 0.5, -1.0, 1.0]))
    with pytest.raises(plica.SolveFailed, match="step after 1 iterations = "):
        estimate(MarginalLikelihood(layered_model(far, flow)), options=Scoring(max_iterations=1))


class Fragile(MarginalLikelihood):
    """Fails where the viscosity's logarithm is farther above its prior's than `reach`."""

    failure: Exception = plica.SolveFailed("LinearSolver: the matrix is singular.")
    reach = 1.05

    def evaluate(self, x: Any) -> Evaluation:
        if x[0] > self.prior_mean[0] + self.reach:
            raise self.failure
        return super().evaluate(x)


@pytest.mark.parametrize("failure", [plica.SolveFailed("singular"), np.linalg.LinAlgError("singular")])
def test_a_step_into_where_a_solve_fails_is_halved(failure: Exception) -> None:
    """From a prior too low by a factor of e: the first step is too long for it."""
    names: list[Any] = [VISCOSITY, "cover.E"]
    flow = simulated(layered_model(names, np.ones((20, 12, 2))), np.random.default_rng(1), pressure=5.0)
    model = layered_model(offset(names, np.array([-1.0, 0.3])), flow)
    fragile = Fragile(model)
    fragile.failure = failure
    plain = estimate(MarginalLikelihood(model), options=Scoring(longest_step=3.0))
    found = estimate(fragile, options=Scoring(longest_step=3.0))
    assert np.abs((found.mean - plain.mean) / plain.sd).max() < 0.05


def test_a_step_that_cannot_be_taken_says_what_failed() -> None:
    names: list[Any] = [VISCOSITY, "cover.E"]
    flow = simulated(layered_model(names, np.ones((20, 12, 2))), np.random.default_rng(1), pressure=5.0)
    fragile = Fragile(layered_model(offset(names, np.array([-1.0, 0.3])), flow))
    fragile.reach = 1e-9
    with pytest.raises(plica.SolveFailed, match=r"no step of .* could not be evaluated: LinearSolver: the"):
        estimate(fragile, options=Scoring(longest_step=3.0, max_halvings=2))


def test_a_level_at_its_bound_stands_in_the_posterior_s_warnings() -> None:
    flow = simulated(layered_model(["cover.E"], np.ones((10, 12, 2))), np.random.default_rng(0), pressure=0.0)
    found = estimate(MarginalLikelihood(layered_model(["cover.E"], flow)))
    assert found.noise.at_least == ("pressure",)
    assert any("lower bound of its search" in text for text in posterior_warnings(found))


def test_points_between_nodes_follow_the_shape_functions() -> None:
    """A quadratic field is met exactly by the faces with six nodes, seen from above and from a tilt."""
    mesh = layered_mesh()
    x = np.asarray(mesh.points)
    for camera in (CAMERA, replace(CAMERA, tilt=-6.0, lean=3.0, roll=30.0)):
        place = np.array([[1.1e-3, 2.2e-3, SIZE[2]], [3.3e-3, 4.4e-3, SIZE[2]]])
        seen = SurfacePoints.seen(mesh, "z_max", camera, shown(place, camera))
        assert np.allclose(np.einsum("rk,rkc->rc", seen.weights, x[seen.nodes]), place, atol=1e-12)
        values = x[:, 0] * x[:, 1] + x[:, 1] ** 2
        found = np.sum(seen.weights * values[seen.nodes], axis=1)
        assert np.allclose(found, place[:, 0] * place[:, 1] + place[:, 1] ** 2, atol=1e-15)


def test_rows_are_pixels_to_the_right_and_down() -> None:
    """How far the camera's picture of a point moves when its tissue does."""
    mesh = layered_mesh()
    for camera in (CAMERA, replace(CAMERA, tilt=-11.0, lean=6.0, roll=20.0)):
        seen = SurfacePoints.at_nodes(np.asarray(mesh.node_sets["z_max"])[:3])
        observation = Observation(seen, camera, np.ones((2, 3, 2)))
        unknowns, rows = observation.displacements()
        x = np.asarray(mesh.points)
        u = 1e-3 * np.random.default_rng(2).normal(size=x.shape)
        moved = (shown(x + u, camera) - shown(x, camera))[seen.nodes[:, 0]]
        assert np.allclose(rows @ u.ravel()[unknowns], moved.ravel(), rtol=0, atol=1e-10)
    up = np.zeros_like(x)
    up[:, 1] = 1e-3
    lifted = Observation(seen, CAMERA, np.ones((2, 3, 2))).displacements()[1] @ up.ravel()[unknowns]
    assert lifted.reshape(3, 2) == pytest.approx(np.tile([0.0, -20.0], (3, 1)))


def test_an_unknown_tilt_is_estimated_with_the_tissue() -> None:
    """Ten degrees of tilt and of lean, seen by a camera that believes to look straight down."""
    angles, rng = np.array([-10.0, -10.0]), np.random.default_rng(13)
    tilted = replace(CAMERA, tilt=angles[0], lean=angles[1])
    truth = layered_model(NAMES, np.ones((FRAMES, 12, 2)), camera=tilted)
    flow = simulated(truth, rng, pressure=5.0)
    found = estimate(MarginalLikelihood(layered_model(NAMES, flow, tilt_sd=11.0)))
    exact = np.append(truth.tissue.prior_mean, angles)
    assert np.abs((found.mean - exact) / found.sd).max() < 3.5
    assert (found.sd[4:] < 0.5 * 11.0).all()
    assert found.median[4:] == pytest.approx(found.mean[4:])
    assert found.interval()[4:] == pytest.approx(
        found.mean[4:, None] + 1.959964 * found.sd[4:, None] * [-1, 1]
    )
    assert "tilt  " in posterior_table(found)
    straight = MarginalLikelihood(layered_model(NAMES, flow)).value(found.mean[:4])
    assert found.log_likelihood > straight + 10


def test_a_tilt_s_prior_is_about_what_the_camera_says() -> None:
    camera, flow = replace(CAMERA, tilt=4.0, lean=-7.0), np.ones((4, 12, 2))
    likelihood = MarginalLikelihood(layered_model(["cover.E"], flow, camera=camera, tilt_sd=2.0))
    assert likelihood.prior_mean[1:] == pytest.approx([4.0, -7.0])
    assert likelihood.prior_sd[1:] == pytest.approx([2.0, 2.0])
    known = MarginalLikelihood(layered_model(["cover.E"], flow, camera=camera))
    at = likelihood.prior_mean
    assert likelihood.value(at) == pytest.approx(known.value(at[:1]), rel=1e-12)
