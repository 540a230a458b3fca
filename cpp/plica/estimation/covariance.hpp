#pragma once
#include "plica/estimation/product.hpp"

namespace plica::estimation {

/// The products, factors and solves that a Kalman filter and smoother are made of. A covariance is symmetric and
/// kept whole; only one triangle is computed, the other is its copy, so that symmetry holds to the bit.

/// C = G P G^T, or C += G P G^T: G (m, n), P (n, n) symmetric, C (m, m). 2 m n^2 + m^2 n operations.
void congruence(const MatrixView& g, const MatrixView& p, const MatrixSpan& c, Into into);

/// C = A B, or C += A B, where the product is known to be symmetric. n^2 k operations.
void symmetric_product(const MatrixView& a, const MatrixView& b, const MatrixSpan& c, Into into);

/// P += scale W^T W: W (r, n), P (n, n) symmetric. n^2 r operations.
void gram_update(double scale, const MatrixView& w, const MatrixSpan& p);

/// The upper triangular R of A = R^T R in place of A (n, n), zero below the diagonal. n^3 / 3 operations.
/// The first row whose pivot is not positive (A is then half way), or n where all were.
std::ptrdiff_t cholesky(const MatrixSpan& a);

/// X = R^-T X in place: R (n, n) upper, X (n, m). n^2 m operations.
void solve_lower(const MatrixView& r, const MatrixSpan& x);

/// X = R^-1 X in place.
void solve_upper(const MatrixView& r, const MatrixSpan& x);

}  // namespace plica::estimation
