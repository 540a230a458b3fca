"""The marginal likelihood of a recording, in input-space form, with its gradient and Fisher information.

y = mu(theta) + T(theta) w + v, w ~ N(0, sigma_p^2) in the pressures and N(0, sigma_c^2) in the forces of
closed frames, v ~ N(0, sigma_v^2 R). The covariance of y is never formed: with W = R^-1, zero where y is
missing, and Q = diag(sigma_p^2, sigma_c^2) / sigma_v^2, everything follows from T' W T and
S = Q^-1 + T' W T (docs/identification_theory.md).
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from plica.errors import InvalidInput
from plica.identify.likelihood.evaluation import Evaluation
from plica.identify.likelihood.flow_error import FlowError, Whitening
from plica.identify.likelihood.information import gradient_and_information
from plica.identify.likelihood.input_space import InputSpace, Solved
from plica.identify.likelihood.likelihood import log_prior
from plica.identify.likelihood.noise_levels import Noise
from plica.identify.likelihood.residuals import ResidualTest, innovations, residual_test
from plica.identify.model.model import MotionModel, Responses

__all__ = ["MarginalLikelihood"]

Array = NDArray[np.float64]
_TILT = ("tilt", "lean")


class MarginalLikelihood:
    """log p(y | theta) of a model's observation as a function of log theta: a `Likelihood`.

    Parameters
    ----------
    model : MotionModel
    noise : Noise, optional
        Fixed noise levels; default: those that maximise the likelihood at each point. The forcing's
        `collision_sd` takes precedence over the level of the collisions.
    flow_error : FlowError, optional
        Error model of the flow, instead of independent errors with the observation's sd. The gains of the
        points are then unknown inputs too.

    Notes
    -----
    The coordinates x (p) are the logarithms of the model's parameters, then the camera's tilt and lean
    (degrees) if the observation has a `tilt_sd`, then the logarithm of the gain if the forcing has a
    `gain_sd`. `value_and_gradient` is the function for an optimiser or a sampler::

        result = scipy.optimize.minimize(
            lambda x: [-part for part in likelihood.value_and_gradient(x)], start, jac=True)

    One call costs one sweep of (1 + p) (q + c) columns; the result of the last point is kept.
    """

    def __init__(
        self, model: MotionModel, noise: Noise | None = None, flow_error: FlowError | None = None
    ) -> None:
        if noise is not None and not (
            noise.flow > 0 and min(noise.pressure, noise.collision, noise.gain) >= 0
        ):
            raise InvalidInput(
                f"MarginalLikelihood: noise = {noise.pressure:g} Pa, {noise.flow:g}, {noise.collision:g} "
                f"Pa, {noise.gain:g}; must be >= 0, > 0, >= 0 and >= 0."
            )
        self.model, self.fixed_noise, self.flow_error = model, noise, flow_error
        observation, forcing = model.observation, model.forcing
        self.whitening: Whitening | None = None
        self._y = observation.rows
        weights, gains = None, None
        if flow_error is not None:
            self.whitening = Whitening(flow_error, observation.weights)
            self._y, weights = self.whitening(self._y), self.whitening.weights
            gains = self.whitening.gains(flow_error.motion)
        self.inputs = InputSpace(observation, forcing, weights, gains)
        self._last: Evaluation | None = None
        self._kept: tuple[Evaluation, Solved] | None = None

    @property
    def names(self) -> tuple[str, ...]:
        """(p) Names of the coordinates."""
        return self.model.tissue.names + _TILT * self._tilts + ("gain",) * self._has_gain

    @property
    def units(self) -> tuple[str, ...]:
        """(p)"""
        return self.model.tissue.units + ("deg", "deg") * self._tilts + ("",) * self._has_gain

    @property
    def logarithmic(self) -> NDArray[np.bool_]:
        """(p) Whether each coordinate is a logarithm; angles are not."""
        return ~np.isin(self.names, _TILT)

    @property
    def prior_mean(self) -> Array:
        """(p)"""
        camera = self.model.observation.camera
        nuisances = [camera.tilt, camera.lean] * self._tilts + [0.0] * self._has_gain
        return np.append(self.model.tissue.prior_mean, nuisances)

    @property
    def prior_sd(self) -> Array:
        """(p)"""
        nuisances = [self.model.observation.tilt_sd] * (2 * self._tilts)
        nuisances += [self.model.forcing.gain_sd] * self._has_gain
        return np.append(self.model.tissue.prior_sd, nuisances)

    @property
    def _has_gain(self) -> bool:
        return self.model.forcing.gain_sd > 0

    @property
    def _tilts(self) -> bool:
        return self.model.observation.tilt_sd > 0

    def _responses(self, at: Array, derivatives: bool) -> Responses:
        count = len(self.model.tissue.names)
        angles = (float(at[count]), float(at[count + 1])) if self._tilts else None
        return self.model.responses(at[:count], derivatives, angles)

    def value_and_gradient(self, x: ArrayLike) -> tuple[float, Array]:
        """log p(y | x) + log prior(x), up to a constant, and its gradient (p).

        x (p) log theta. Returns -inf and a gradient of nan where a material is not positive definite.
        """
        at = np.array(x, dtype=float)
        try:
            evaluation = self.evaluate(at)
        except InvalidInput:
            if at.shape != self.prior_mean.shape or not np.isfinite(at).all():
                raise
            return -math.inf, np.full(at.shape, np.nan)
        gradient = evaluation.gradient - (at - self.prior_mean) / self.prior_sd**2
        return evaluation.value + log_prior(self, at), gradient

    def value(self, x: ArrayLike) -> float:
        """log p(y | x) without the prior and without derivatives: cheaper by the factor 1 + p."""
        at = self._point(x)
        responses = self._responses(at, derivatives=False)
        return self._solved(at, self._whitened(responses)).value

    def evaluate(self, x: ArrayLike) -> Evaluation:
        """The log-likelihood at x (p), its gradient and Fisher information, without the prior."""
        at = self._point(x)
        if self._last is not None and np.array_equal(self._last.point, at):
            return self._last
        responses = self._responses(at, derivatives=True)
        self._last = self._differentiated(at, responses)
        return self._last

    def evaluate_known(self, x: ArrayLike, responses: Responses) -> Evaluation:
        """`evaluate` with known responses of the model at x, for studies of many recordings of one tissue."""
        self._last = self._differentiated(self._point(x), responses)
        return self._last

    def of_first(self, share: float) -> MarginalLikelihood:
        """The likelihood of the first frames alone that contain this share, in (0, 1], of the frames with
        data. Raises InvalidInput if that is too short, or shows no motion."""
        if not 0 < share <= 1:
            raise InvalidInput(f"MarginalLikelihood: share = {share:g}; must be in (0, 1].")
        seen = np.flatnonzero(self.model.observation.weights.any(axis=1))
        count = max(math.ceil(share * len(seen) - 1e-9), 1)  # 7 / 25 of 25 is 7, which it exceeds in floats
        frames = int(seen[count - 1]) + 1
        error = None if self.flow_error is None else self.flow_error.of_first(frames)
        return MarginalLikelihood(self.model.of_first(frames), self.fixed_noise, error)

    def _point(self, x: ArrayLike) -> Array:
        at = np.array(x, dtype=float)
        if at.shape != self.prior_mean.shape or not np.isfinite(at).all():
            raise InvalidInput(f"MarginalLikelihood: x must be {len(self.names)} finite numbers.")
        return at

    def motion(self, at: Evaluation) -> Array:
        """(N, m) px/frame, mu + T w at the expected inputs, for all rows, missing or not."""
        mean = self._gain(at.point) * at.responses.mean[0]
        return np.asarray(mean + self.inputs.moved(at.responses.lags[0], self.solved(at).inputs))

    def gain_part(self, at: Evaluation) -> Array:
        """(N, m) px/frame, contribution of the expected gains of the flow's points to that motion."""
        if self.flow_error is None:
            return np.zeros(self.model.observation.weights.shape)
        motion = self.flow_error.motion
        own = self.solved(at).inputs[len(self.inputs.chosen) :].reshape(-1, 2, 2)
        return np.asarray(np.einsum("pcd,tpd->tpc", own, motion).reshape(len(motion), -1))

    def error(self, at: Evaluation) -> Array:
        """(N, m') y - mu of the rows with independent errors; zero where missing."""
        s = self.solved(at)
        return np.where(self.inputs.weights > 0, s.residual + self.inputs.spread(s.lags, s.inputs), 0.0)

    def innovations(self, at: Evaluation, columns: Array) -> Array:
        """Columns (N, m', k) of these rows, whitened as `error` is: (N, m, k) of the observed rows, scaled to
        variance sigma_v^2; nan where y is missing or determines the initial state."""
        white = innovations(self.inputs, self.solved(at), columns)
        if self.whitening is None:
            return white
        rows = self.model.observation.weights.shape[1]
        unfolded = [self.whitening.unfolded(white[..., j], rows) for j in range(columns.shape[2])]
        return np.stack(unfolded, axis=-1)

    def whitened(self, at: Evaluation) -> Array:
        """(N, m) innovations of y - mu of variance 1 if the model holds; nan where y is missing or determines
        the initial state."""
        return self.innovations(at, self.error(at)[..., None])[..., 0] / at.noise.flow

    def residual_test(self, at: Evaluation) -> ResidualTest:
        """The scores of these innovations: in time, among neighbours in the image, of tails and level."""
        return residual_test(self.whitened(at), self.model.image_positions)

    def sensitivities(self, at: Evaluation) -> Array:
        """(N, m', p) derivatives of mu + T w of these rows at the expected inputs."""
        rows, s = self._whitened(at.responses), self.solved(at)
        found = self._mean_derivatives(at.point, rows, s)
        for j, lags in enumerate(rows.lags[1:]):
            found[j] = found[j] + self.inputs.moved(lags, s.inputs)
        return np.stack(found, axis=-1)

    def solved(self, at: Evaluation) -> Solved:
        """The solution with the factor of S at an evaluated point; that of the last point is kept."""
        if self._kept is None or self._kept[0] is not at:
            self._kept = (at, self._solved(at.point, self._whitened(at.responses)))
        return self._kept[1]

    def _whitened(self, responses: Responses) -> Responses:
        """Responses of the rows with independent errors."""
        if self.whitening is None:
            return responses
        return Responses(self.whitening(responses.mean, axis=1), self.whitening(responses.lags, axis=1))

    def _solved(self, at: Array, responses: Responses) -> Solved:
        mean, lags = self._gain(at) * responses.mean[0], responses.lags[0]
        error = np.where(self.inputs.weights > 0, self._y - mean, 0.0)
        return Solved(self.inputs, mean, lags, error, self.fixed_noise)

    def _differentiated(self, at: Array, observed: Responses) -> Evaluation:
        rows = self._whitened(observed)
        s = self._solved(at, rows)
        gradient, information = gradient_and_information(
            self.inputs, s, self._mean_derivatives(at, rows, s), rows.lags[1:], self.fixed_noise is None
        )
        inputs = s.inputs[: len(self.inputs.scale)] * self.inputs.scale
        residual = s.residual
        if self.whitening is not None:
            left = self.model.observation.rows - self._gain(at) * observed.mean[0]
            left = left - self.inputs.moved(observed.lags[0], s.inputs)
            residual = np.where(self.model.observation.weights > 0, left, 0.0)
        return Evaluation(at, s.value, gradient, information, s.noise, inputs, residual, observed)

    def _gain(self, at: Array) -> float:
        """The factor on the drive."""
        return math.exp(at[-1]) if self._has_gain else 1.0

    def _mean_derivatives(self, at: Array, rows: Responses, s: Solved) -> list[Array]:
        """p derivatives of mu, (N, m')."""
        gain = self._gain(at)
        return [gain * d for d in rows.mean[1:]] + [s.mean] * self._has_gain
