"""The state-space filter, the evolution of a scene, and the estimator of tissue."""
