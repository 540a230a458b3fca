#pragma once
#include "plica/core/block_matrix.hpp"
#include "plica/solve/subtrees.hpp"

namespace plica {

/// What a factorisation will take, known before it is made.
struct FactorPlan {
  Supernodes tree;
  std::vector<std::int32_t> alone;  // nodes without neighbours: those held altogether
  std::ptrdiff_t bytes() const { return tree.floats() * static_cast<std::ptrdiff_t>(sizeof(float)); }

  /// Blocks of A that are zero couple nothing. A must have a symmetric pattern.
  explicit FactorPlan(const BlockMatrix& A);
};

/// S A S ~ L L^T in single precision, S = diag(A)^(-1/2), A symmetric positive definite; computed in double
/// precision by fronts (Duff and Reid 1983) along the tree of supernodes, then rounded. Threaded over subtrees;
/// the same bits for any number of threads. A solve streams L twice. Per column, A x = b holds to some 1e-7 times
/// the condition number of S A S.
class TriangularFactor {
 public:
  /// Throws SolveFailed where a pivot is below 1e-12 of its unknown's diagonal entry.
  TriangularFactor(const BlockMatrix& A, FactorPlan plan);

  /// x ~ A^-1 b (3 n). A zero b gives zero.
  void solve(const Vector& b, Vector& x) const;
  /// The same for `pack` right-hand sides at once, b[pack * unknown + vector]; L is streamed twice for all of them
  /// and each takes the same arithmetic whatever its company.
  void solve_packed(const double* b, double* x) const;
  static constexpr int pack = BlockMatrix::pack;
  /// The same for `wide` of them, b[wide * unknown + vector]: the bits of solve_packed.
  void solve_wide(const double* b, double* x) const;
  static constexpr int wide = 2 * pack;
  const FactorPlan& plan() const { return plan_; }

 private:
  struct Fronts;
  template <int lanes>
  void apply(const double* b, double* x) const;

  FactorPlan plan_;
  Subtrees subtrees_;
  std::vector<double> scale_;              // (3 n) diag(A)^(-1/2)
  std::vector<double> alone_inverse_;      // (9 alone) of their blocks
  std::vector<std::ptrdiff_t> panel_;      // (count) where a supernode's tiles begin
  std::vector<std::ptrdiff_t> front_;      // (count + 1) where its vector begins: padded columns, padded rows
  std::vector<std::ptrdiff_t> in_parent_;  // (rows) place of a row below in its parent's vector
  std::vector<std::ptrdiff_t> as_column_;  // (rows) and where it is a column
  Eigen::VectorXf values_;                 // the tiles
};

}  // namespace plica
