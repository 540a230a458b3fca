#include "plica/dynamics/last_basis.hpp"

#include <cstring>

#include "plica/core/eigenpairs.hpp"
#include "plica/core/error.hpp"
#include "plica/core/require.hpp"

namespace plica {

namespace {

/// To the bit: zeros of other signs, and what is no number, count as different or as the same as they are stored.
bool same_bits(const double* a, const double* b, std::ptrdiff_t count) {
  return std::memcmp(a, b, static_cast<std::size_t>(count) * sizeof(double)) == 0;
}

bool same_rows(const NodePattern& a, const NodePattern& b) {
  return &a == &b || (a.row_start == b.row_start && a.column == b.column);
}

}  // namespace

Eigen::MatrixXd mass_orthonormal(const NodalMatrix& M, Eigen::MatrixXd B) {
  require_size("mass_orthonormal", "a vector", B.rows(), M.rows());
  constexpr double independent = 1e-12;  // of the largest eigenvalue: 1e-6 of a length
  // Twice: what is left of nearly parallel columns is then orthonormal to round-off too.
  for (int round = 0; round < 2; ++round) {
    for (std::ptrdiff_t j = 0; j < B.cols(); ++j)
      if (const double norm = std::sqrt(B.col(j).dot(M * Vector(B.col(j)))); norm > 0) B.col(j) /= norm;
    const Eigen::MatrixXd gram = B.transpose() * times_columns(M, B);
    const auto [size, vectors] = symmetric_eigenpairs(0.5 * (gram + gram.transpose()));
    if (!(size.maxCoeff() > 0))
      throw InvalidInput("Reduction: the basis moves nothing; must have a vector that moves a node that is free.");
    const std::ptrdiff_t kept = (size.array() > independent * size.maxCoeff()).count();
    const Vector scale = size.tail(kept).cwiseSqrt().cwiseInverse();
    B = Eigen::MatrixXd(B * vectors.rightCols(kept) * scale.asDiagonal());
  }
  return B;
}

Eigen::MatrixXd LastBasis::orthonormal(const NodalMatrix& mass, const Eigen::MatrixXd& vectors) {
  const std::lock_guard<std::mutex> one(guard_);
  const std::vector<double>& values = mass.values();
  const bool same = pattern_ && vectors.rows() == vectors_.rows() && vectors.cols() == vectors_.cols() &&
                    values.size() == mass_.size() && same_rows(*mass.pattern(), *pattern_) &&
                    same_bits(values.data(), mass_.data(), static_cast<std::ptrdiff_t>(values.size())) &&
                    same_bits(vectors.data(), vectors_.data(), vectors.size());
  if (!same) {
    pattern_.reset();  // nothing is kept of what fails
    found_ = mass_orthonormal(mass, vectors);
    mass_ = values;
    vectors_ = vectors;
    pattern_ = mass.pattern();
  }
  return found_;
}

}  // namespace plica
