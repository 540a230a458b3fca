"""The border of the covariance kernels: any strides in, rows in place, shapes that fit."""

from __future__ import annotations

import numpy as np
import pytest

import plica
from plica import _engine

RNG = np.random.default_rng(1)
A = RNG.standard_normal((70, 70))
P = A @ A.T + 70 * np.eye(70)


def test_arrays_of_any_strides_are_taken_as_they_lie() -> None:
    wide = RNG.standard_normal((140, 210))
    part = wide[::-2, ::3]  # 70 x 70, negative and wide strides
    # Sums of 70 products of the size of 1.
    np.testing.assert_allclose(_engine.product(part, A.T), part @ A.T, atol=1e-13)
    np.testing.assert_allclose(_engine.product(part.T, A), part.T @ A, atol=1e-13)
    moved = part.T @ P[::-1, ::-1] @ part  # entries to 1e4, sums of 70 products twice
    np.testing.assert_allclose(
        _engine.congruence(part.T, P[:, ::-1][::-1], np.eye(70)), np.eye(70) + moved, atol=1e-10
    )
    np.testing.assert_array_equal(_engine.product(np.eye(3, dtype=int), np.eye(3, dtype=int)), np.eye(3))


def test_updates_and_solves_work_in_place() -> None:
    updated, W = P.copy(), A[:20]
    assert _engine.gram_update(updated, W, -0.5) is None
    np.testing.assert_allclose(updated, P - 0.5 * W.T @ W, rtol=1e-12, atol=1e-12)
    R = _engine.cholesky(P)
    np.testing.assert_allclose(R.T @ R, P, rtol=1e-13, atol=1e-12)
    wide = np.zeros((70, 100))
    X = wide[:, 10:80]
    X[:] = A
    _engine.solve_lower(R, X)
    _engine.solve_upper(R, X)
    np.testing.assert_allclose(P @ X, A, atol=1e-12)
    assert not wide[:, :10].any()
    assert not wide[:, 80:].any()


def test_what_cannot_be_multiplied_is_refused() -> None:
    records = np.zeros((4, 4), dtype=[("flag", "i4"), ("value", "f8")])
    cases = [
        (lambda: _engine.product(A, A[:3]), r"product: b has shape \(3, 70\); must be \(70, 70\)"),
        (lambda: _engine.product(A[0], A), r"product: a has shape \(70,\); must be \(rows, columns\)"),
        (lambda: _engine.product(records["value"], np.eye(4)), "a does not lie on a grid of 8 bytes"),
        (lambda: _engine.symmetric_product(A[:3], A), r"symmetric_product: b has shape .*must be \(70, 3\)"),
        (lambda: _engine.congruence(A[:3], P, P), r"congruence: plus has shape \(70, 70\); must be \(3, 3\)"),
        (
            lambda: _engine.gram_update(P[:3], A, 1.0),
            r"gram_update: p has shape \(3, 70\); must be \(70, 70\)",
        ),
        (lambda: _engine.gram_update(P.copy().T, A, 1.0), "p is not contiguous along its rows"),
        (lambda: _engine.cholesky(A[:3]), r"cholesky: a has shape \(3, 70\); must be \(3, 3\)"),
        (
            lambda: _engine.solve_lower(P, A[:3].copy()),
            r"solve_lower: x has shape \(3, 70\); must be \(70, 70\)",
        ),
        (lambda: _engine.solve_upper(P, A.copy()[:, ::2]), "x is not contiguous along its rows"),
        (lambda: _engine.solve_upper(P.copy().T, A.copy()), "r is not contiguous along its rows"),
    ]
    for call, message in cases:
        with pytest.raises(plica.InvalidInput, match=message):
            call()
    with pytest.raises(TypeError):  # nothing is converted that is written in place
        _engine.gram_update(np.eye(70, dtype=np.float32), A, 1.0)
    with pytest.raises(
        plica.SolveFailed, match="the pivot of row 2 of 3 is not > 0; the matrix must be positive"
    ):
        _engine.cholesky(np.diag([1.0, 1.0, -1.0]))


def test_what_is_read_only_is_not_written() -> None:
    fixed = P.copy()
    fixed.flags.writeable = False
    with pytest.raises((ValueError, plica.InvalidInput)):
        _engine.gram_update(fixed, A, 1.0)
    np.testing.assert_array_equal(fixed, P)
