"""The example that samples the posterior of the tissue: its sampler, and that it agrees with the Gaussian."""

from __future__ import annotations

import re
import runpy
import sys
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from repository import ROOT

EXAMPLE = str(ROOT / "examples" / "identify_sampling.py")


def test_the_sampler_draws_from_a_correlated_gaussian() -> None:
    """Mean and covariance of 4000 draws; draws are nearly independent, so 0.08 sd is five standard errors
    of the mean, and 0.12 five of a variance, relative."""
    hamiltonian: Any = runpy.run_path(EXAMPLE)["hamiltonian"]
    mean, covariance = np.array([1.0, -2.0]), np.array([[0.5, 0.3], [0.3, 0.4]])
    precision = np.linalg.inv(covariance)

    def density(x: NDArray[np.float64]) -> tuple[float, NDArray[np.float64]]:
        slope = -precision @ (x - mean)
        return float(0.5 * slope @ (x - mean)), slope

    draws = hamiltonian(density, mean, np.diag(np.sqrt(np.diag(covariance))), 4000, seed=3)
    sd = np.sqrt(np.diag(covariance))
    assert np.abs((draws.mean(axis=0) - mean) / sd).max() < 0.08
    assert np.abs((np.cov(draws.T) - covariance) / np.outer(sd, sd)).max() < 0.12


def test_sampling_and_the_gaussian_agree(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(sys, "argv", ["identify_sampling.py", "80", "10"])
    runpy.run_path(EXAMPLE, run_name="__main__")
    message = capsys.readouterr().out
    apart = re.search(r"maximum is (\S+) sd", message)
    assert apart is not None
    assert float(apart[1]) < 0.1  # estimate's own tolerance is 0.05 sd
    rows = re.findall(r"^(body\.E|body\.viscosity|gain)\s+(.+)$", message, flags=re.MULTILINE)
    assert len(rows) == 3
    for name, row in rows:
        truth, *others = map(float, row.replace(" - ", " ").split())
        gaussian, sampled = np.log(others[:3]), np.log(others[3:])
        sd = (gaussian[2] - gaussian[1]) / (2 * 1.96)
        assert abs(sampled[0] - gaussian[0]) < 0.6 * sd, (
            name
        )  # 72 draws: 0.15 sd of a median, and what is not Gaussian
        assert 0.6 < (sampled[2] - sampled[1]) / (gaussian[2] - gaussian[1]) < 1.6, name
        assert abs(np.log(truth) - gaussian[0]) < 4 * sd, name
