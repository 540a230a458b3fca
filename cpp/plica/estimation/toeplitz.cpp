#include "plica/estimation/toeplitz.hpp"

#include <algorithm>
#include <map>

#include "plica/core/require.hpp"
#include "plica/core/threads.hpp"

namespace plica::estimation {
namespace {

using Lags = BlockToeplitz::Lags;

/// The weight that most frames give a row.
Vector most_common(const Lags& weights) {
  Vector common(weights.cols());
  for (std::ptrdiff_t r = 0; r < weights.cols(); ++r) {
    std::map<double, int> count;
    for (std::ptrdiff_t k = 0; k < weights.rows(); ++k) ++count[weights(k, r)];
    common[r] = std::max_element(count.begin(), count.end(), [](const auto& a, const auto& b) {
                  return a.second < b.second;
                })->first;
  }
  return common;
}

/// [lag 0 | lag 1 | ...]: (rows, N columns).
Lags side_by_side(const BlockToeplitz& T) {
  Lags wide(T.rows(), T.blocks * T.columns());
  for (std::ptrdiff_t l = 0; l < T.blocks; ++l) wide.middleCols(l * T.columns(), T.columns()) = T.lag(l);
  return wide;
}

/// Rows `chosen` of T's block row k, where it is not zero: lag k, lag k - 1, ..., lag 0.
Lags rows_of(const BlockToeplitz& T, std::ptrdiff_t k, const std::vector<std::ptrdiff_t>& chosen) {
  Lags part(static_cast<std::ptrdiff_t>(chosen.size()), (k + 1) * T.columns());
  for (std::ptrdiff_t i = 0; i <= k; ++i)
    for (std::ptrdiff_t r = 0; r < part.rows(); ++r)
      part.block(r, i * T.columns(), 1, T.columns()) = T.lag(k - i).row(chosen[static_cast<std::size_t>(r)]);
  return part;
}

void require_blocks(const char* where, const BlockToeplitz& T) {
  require_at_least(where, "the blocks", T.blocks, 1);
  if (T.lags.rows() % T.blocks != 0)
    refuse_size(where, "the rows of lags", T.lags.rows(),
                "a multiple of the " + std::to_string(T.blocks) + " blocks");
}

}  // namespace

Lags toeplitz_gram(const BlockToeplitz& A, const BlockToeplitz& B, const Lags& weights) {
  require_blocks("toeplitz_gram", A);
  require_blocks("toeplitz_gram", B);
  require_size("toeplitz_gram", "the blocks of B", B.blocks, A.blocks);
  require_size("toeplitz_gram", "the rows of a block of B", B.rows(), A.rows());
  require_size("toeplitz_gram", "rows of weights", weights.rows(), A.blocks);
  require_size("toeplitz_gram", "columns of weights", weights.cols(), A.rows());
  const std::ptrdiff_t N = A.blocks, a = A.columns(), b = B.columns();
  const Vector common = most_common(weights);
  const Lags wide_A = side_by_side(A), wide_B = common.asDiagonal() * side_by_side(B);
  Lags products(N * a, N * b);  // block (l, m): lag_A[l]' W lag_B[m]
  for_chunks(N, 16, [&](std::ptrdiff_t begin, std::ptrdiff_t end, std::ptrdiff_t) {
    products.middleRows(begin * a, (end - begin) * a).noalias() =
        wide_A.middleCols(begin * a, (end - begin) * a).transpose() * wide_B;
  });
  Lags gram(N * a, N * b);
  for_chunks(N, 8, [&](std::ptrdiff_t begin, std::ptrdiff_t end, std::ptrdiff_t) {
    for (std::ptrdiff_t offset = begin; offset < end; ++offset)
      for (int side = 0; side < (offset ? 2 : 1); ++side)  // the diagonals j - i = offset and i - j = offset
        for (std::ptrdiff_t s = N - 1 - offset; s >= 0; --s) {
          const std::ptrdiff_t i = side ? s + offset : s, j = side ? s : s + offset;
          auto block = gram.block(i * a, j * b, a, b);
          block = products.block((N - 1 - i) * a, (N - 1 - j) * b, a, b);
          if (s < N - 1 - offset) block += gram.block((i + 1) * a, (j + 1) * b, a, b);
        }
  });
  for (std::ptrdiff_t k = 0; k < N; ++k) {
    std::vector<std::ptrdiff_t> other;
    for (std::ptrdiff_t r = 0; r < weights.cols(); ++r)
      if (weights(k, r) != common[r]) other.push_back(r);
    if (other.empty()) continue;
    const Lags left = rows_of(A, k, other);
    Lags right = rows_of(B, k, other);
    for (std::ptrdiff_t r = 0; r < right.rows(); ++r) {
      const std::ptrdiff_t row = other[static_cast<std::size_t>(r)];
      right.row(r) *= weights(k, row) - common[row];
    }
    for_chunks(left.cols(), 128, [&](std::ptrdiff_t begin, std::ptrdiff_t end, std::ptrdiff_t) {
      gram.block(begin, 0, end - begin, right.cols()).noalias() +=
          left.middleCols(begin, end - begin).transpose() * right;
    });
  }
  return gram;
}

Lags toeplitz_product(const BlockToeplitz& T, const Lags& x) {
  require_blocks("toeplitz_product", T);
  require_size("toeplitz_product", "rows of x", x.rows(), T.blocks * T.columns());
  const std::ptrdiff_t N = T.blocks, m = T.rows(), q = T.columns();
  Lags y = Lags::Zero(N * m, x.cols());
  for_chunks(N, 4, [&](std::ptrdiff_t begin, std::ptrdiff_t end, std::ptrdiff_t) {
    for (std::ptrdiff_t k = begin; k < end; ++k)
      for (std::ptrdiff_t i = 0; i <= k; ++i)
        y.middleRows(k * m, m).noalias() += T.lag(k - i) * x.middleRows(i * q, q);
  });
  return y;
}

Lags toeplitz_transposed_product(const BlockToeplitz& T, const Lags& x) {
  require_blocks("toeplitz_transposed_product", T);
  require_size("toeplitz_transposed_product", "rows of x", x.rows(), T.blocks * T.rows());
  const std::ptrdiff_t N = T.blocks, m = T.rows(), q = T.columns();
  Lags y = Lags::Zero(N * q, x.cols());
  for_chunks(N, 4, [&](std::ptrdiff_t begin, std::ptrdiff_t end, std::ptrdiff_t) {
    for (std::ptrdiff_t i = begin; i < end; ++i)
      for (std::ptrdiff_t k = i; k < N; ++k)
        y.middleRows(i * q, q).noalias() += T.lag(k - i).transpose() * x.middleRows(k * m, m);
  });
  return y;
}

}  // namespace plica::estimation
