"""Identification: state-space models of tissue, their Kalman filter, smoother and EM."""
