#pragma once
#include "plica/core/require.hpp"
#include "plica/core/types.hpp"

namespace plica::estimation {

/// A lower block-Toeplitz matrix T of N x N blocks: block (k, i) is lag[k - i] for k >= i and zero above, lag[l]
/// (rows, columns). `lags` holds them one under the other, (N rows, columns) row-major.
struct BlockToeplitz {
  using Lags = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  Lags lags;
  std::ptrdiff_t blocks;  // N

  std::ptrdiff_t rows() const {
    require_at_least("BlockToeplitz", "the blocks", blocks, 1);
    return lags.rows() / blocks;
  }
  std::ptrdiff_t columns() const { return lags.cols(); }
  auto lag(std::ptrdiff_t l) const {
    require_index("BlockToeplitz", "lag", l, blocks);
    return lags.middleRows(l * rows(), rows());
  }
};

/// A' W B, (N a, N b), with W = diag(weights), weights (N, rows) >= 0.
///
/// Where the weights are the same in every frame, block (i, j) is block (i + 1, j + 1) plus one product of two
/// lags: O(N^2 rows a b) instead of O(N^3 rows a b). Entries of W that differ from their row's most common weight
/// are added one by one, O((k a) (k b)) for one in frame k.
BlockToeplitz::Lags toeplitz_gram(const BlockToeplitz& A, const BlockToeplitz& B,
                                  const BlockToeplitz::Lags& weights);

/// T x: x (N columns, c) -> (N rows, c). O(N^2 rows columns c).
BlockToeplitz::Lags toeplitz_product(const BlockToeplitz& T, const BlockToeplitz::Lags& x);
/// T' x: x (N rows, c) -> (N columns, c).
BlockToeplitz::Lags toeplitz_transposed_product(const BlockToeplitz& T, const BlockToeplitz::Lags& x);

}  // namespace plica::estimation
