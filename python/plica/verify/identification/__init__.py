"""The state-space filter, the evolution of a scene, and the estimator of tissue."""

from plica.verify.identification import estimator, evolution, gaussian

__all__ = ["CASES"]

CASES = (*gaussian.CASES, *evolution.CASES, *estimator.CASES)
