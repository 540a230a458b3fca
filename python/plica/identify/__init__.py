"""Tissue from video: stiffness and viscosity of the vocal folds with calibrated intervals.

>>> from plica.identify import Forcing, MarginalLikelihood, MotionModel, Observation, estimate

An `Observation` is the motion seen by a camera, a `Forcing` the known and unknown pressures, a `MotionModel`
combines them with a scene; `MarginalLikelihood` is a function of log theta, and `estimate` returns its
`Posterior`, as of any other `Likelihood` (docs/identification.md). `identify` does all this from the files of
a recording, like ``plica identify``; `load` reads its results.
"""

from plica.identify.estimator.estimate import estimate
from plica.identify.estimator.flow_estimate import estimate_from_flow
from plica.identify.estimator.posterior import Posterior
from plica.identify.estimator.scoring import Iteration, Scoring
from plica.identify.estimator.wording import posterior_table, posterior_warnings
from plica.identify.identification import Identification, identify, load
from plica.identify.likelihood.evaluation import Evaluation
from plica.identify.likelihood.flow_error import FlowError
from plica.identify.likelihood.likelihood import Evaluated, Likelihood, log_prior
from plica.identify.likelihood.marginal import MarginalLikelihood
from plica.identify.likelihood.noise_levels import Noise
from plica.identify.likelihood.residuals import ResidualTest
from plica.identify.model.forcing import Forcing
from plica.identify.model.model import MotionModel, Responses
from plica.identify.observation.observation import Observation, SurfacePoints
from plica.identify.observation.sources import PixelMotion, open_motion
from plica.identify.parameters import Prior, TissueParameter, TissueParameters
from plica.identify.settings import Estimated, Settings
from plica.identify.state_space.em import EMResult, em
from plica.identify.state_space.evolution import Evolution, hht_evolution
from plica.identify.state_space.frames import compose, frame_difference
from plica.identify.state_space.kalman import Filtered, kalman_filter, log_likelihood
from plica.identify.state_space.linear_gaussian import LinearGaussian, PatternNoise
from plica.identify.state_space.scene_evolution import SceneMatrices, scene_evolution, scene_matrices
from plica.identify.state_space.smoother import Smoothed, smooth
from plica.identify.state_space.structured_em import StructuredResult, structured_em

__all__ = [
    "EMResult",
    "Estimated",
    "Evaluated",
    "Evaluation",
    "Evolution",
    "Filtered",
    "FlowError",
    "Forcing",
    "Identification",
    "Iteration",
    "Likelihood",
    "LinearGaussian",
    "MarginalLikelihood",
    "MotionModel",
    "Noise",
    "Observation",
    "PatternNoise",
    "PixelMotion",
    "Posterior",
    "Prior",
    "ResidualTest",
    "Responses",
    "SceneMatrices",
    "Scoring",
    "Settings",
    "Smoothed",
    "StructuredResult",
    "SurfacePoints",
    "TissueParameter",
    "TissueParameters",
    "compose",
    "em",
    "estimate",
    "estimate_from_flow",
    "frame_difference",
    "hht_evolution",
    "identify",
    "kalman_filter",
    "load",
    "log_likelihood",
    "log_prior",
    "open_motion",
    "posterior_table",
    "posterior_warnings",
    "scene_evolution",
    "scene_matrices",
    "smooth",
    "structured_em",
]
