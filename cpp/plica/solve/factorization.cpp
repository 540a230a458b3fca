#include "plica/solve/factorization.hpp"

#include <algorithm>
#include <cmath>

#include "plica/core/error.hpp"

#ifdef PLICA_WITH_CHOLMOD
#include <Eigen/CholmodSupport>
#else
#include <Eigen/SparseCholesky>
#endif

namespace plica {
namespace {

using Columns = Eigen::SparseMatrix<double, Eigen::ColMajor, int>;

/// A pivot below this share of its diagonal entry has lost all but four digits to cancellation.
constexpr double smallest_pivot = 1e-12;

[[noreturn]] void refuse(const std::string& what) {
  throw SolveFailed("Factorization: matrix is not positive definite: " + what +
                    ". A body without support, or an inverted element?");
}

void check_pivots(const Columns& A, const Vector& pivots, const Eigen::VectorXi& unknown_of_pivot) {
  const Vector diagonal = A.diagonal();
  for (std::ptrdiff_t i = 0; i < pivots.size(); ++i) {
    const int unknown = unknown_of_pivot[i];
    if (!(pivots[i] > smallest_pivot * diagonal[unknown])) {
      refuse("pivot of node " + number_text(unknown / 3) + " along " + "xyz"[unknown % 3] + " = " +
             number_text(pivots[i]) + "; must be > " + number_text(smallest_pivot) +
             " times its diagonal entry, " + number_text(diagonal[unknown]));
    }
  }
}

#ifdef PLICA_WITH_CHOLMOD
class Solver : public Eigen::CholmodSupernodalLLT<Columns, Eigen::Lower> {
 public:
  explicit Solver(const Columns& A) {
    cholmod().print = 0;
    compute(A);
    if (info() != Eigen::Success) {
      refuse("CHOLMOD stopped in column " +
             number_text(m_cholmodFactor ? static_cast<double>(m_cholmodFactor->minor) : 0));
    }
    check_pivots(A, pivots(),
                 Eigen::Map<const Eigen::VectorXi>(static_cast<int*>(m_cholmodFactor->Perm), A.rows()));
  }

 private:
  /// The squared diagonal of L, in the factor's order.
  Vector pivots() const {
    const auto *super = static_cast<const int*>(m_cholmodFactor->super),
               *pi = static_cast<const int*>(m_cholmodFactor->pi),
               *px = static_cast<const int*>(m_cholmodFactor->px);
    const auto* values = static_cast<const double*>(m_cholmodFactor->x);
    Vector result(static_cast<std::ptrdiff_t>(m_cholmodFactor->n));
    for (std::size_t s = 0; s < m_cholmodFactor->nsuper; ++s) {
      const std::ptrdiff_t height = pi[s + 1] - pi[s];
      for (std::ptrdiff_t k = 0; k < super[s + 1] - super[s]; ++k) {
        const double entry = values[px[s] + k * height + k];
        result[super[s] + k] = entry * entry;
      }
    }
    return result;
  }
};
#else
class Solver : public Eigen::SimplicialLDLT<Columns, Eigen::Lower> {
 public:
  explicit Solver(const Columns& A) {
    compute(A);
    if (info() != Eigen::Success) refuse("a pivot is zero");
    check_pivots(A, vectorD(), permutationPinv().indices());
  }
};
#endif

}  // namespace

struct Factorization::State {
  explicit State(const Columns& A) : solver(A), rows(A.rows()) {}
  Solver solver;
  std::ptrdiff_t rows;
};

Factorization::Factorization(const SparseMatrix& A) {
  if (A.rows() != A.cols() || A.rows() == 0) {
    throw InvalidInput("Factorization", "A.rows()", static_cast<double>(A.rows()), "",
                       "the number of columns, " + number_text(static_cast<double>(A.cols())) + ", and > 0");
  }
  for (std::ptrdiff_t row = 0; row < A.outerSize(); ++row) {
    for (SparseMatrix::InnerIterator entry(A, row); entry; ++entry) {
      if (!std::isfinite(entry.value())) {
        throw InvalidInput("Factorization",
                           "A(" + number_text(static_cast<double>(row)) + ", " +
                               number_text(static_cast<double>(entry.col())) + ")",
                           entry.value(), "", "finite");
      }
    }
  }
  state_ = std::make_unique<State>(Columns(A));
}

Factorization::~Factorization() = default;
Factorization::Factorization(Factorization&&) noexcept = default;
Factorization& Factorization::operator=(Factorization&&) noexcept = default;

Vector Factorization::solve(const Vector& b) const {
  if (b.size() != state_->rows) {
    throw InvalidInput("Factorization", "b.size()", static_cast<double>(b.size()), "",
                       "the number of rows, " + number_text(static_cast<double>(state_->rows)));
  }
  return state_->solver.solve(b);
}

std::string Factorization::backend() {
#ifdef PLICA_WITH_CHOLMOD
  return "SuiteSparse CHOLMOD (GPL)";
#else
  return "Eigen SimplicialLDLT";
#endif
}

}  // namespace plica
