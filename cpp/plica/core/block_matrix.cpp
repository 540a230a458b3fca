#include "plica/core/block_matrix.hpp"

#include <algorithm>
#include <limits>

#include "plica/core/block_product.hpp"
#include "plica/core/error.hpp"
#include "plica/core/require.hpp"
#include "plica/core/threads.hpp"

namespace plica {
namespace {

Pattern checked(Pattern pattern, const std::string& where) {
  if (!pattern || pattern->row_start.empty()) {
    throw InvalidInput(where + ": pattern is empty; must have a row_start of n + 1 entries.");
  }
  const NodePattern& p = *pattern;
  const auto n = static_cast<std::int32_t>(p.rows());
  if (p.row_start.front() != 0 || p.row_start.back() != p.entries()) {
    throw InvalidInput(where, "pattern.row_start.back()", p.row_start.back(), "",
                       "the number of columns, " + number_text(static_cast<double>(p.entries())));
  }
  for (std::int32_t i = 0; i < n; ++i) {
    const std::int32_t begin = p.row_start[i], end = p.row_start[i + 1];
    bool good = begin < end && end <= p.entries() && p.column[begin] >= 0 && p.column[end - 1] < n;
    for (std::int32_t e = begin + 1; good && e < end; ++e) good = p.column[e - 1] < p.column[e];
    if (!good || !std::binary_search(p.column.begin() + begin, p.column.begin() + end, i)) {
      throw InvalidInput(where, "pattern row", i, "", "columns in ascending order with the diagonal among them");
    }
  }
  return pattern;
}

void check_product(const char* where, std::ptrdiff_t rows, const Vector& x, const Vector& y) {
  require_size(where, "x", x.size(), rows);
  if (&x == &y) throw InvalidInput(std::string(where) + ": y is x; must be another vector.");
}

/// Compressed scalar rows of a matrix whose entry e of node row i gives `width` numbers in each of 3 rows.
/// value(e, r, c) is the c-th of them, in column 3 * node column + first(r) + c.
template <typename Value, typename First>
SparseMatrix expand(const NodePattern& p, int width, const Value& value, const First& first) {
  const std::ptrdiff_t count = 3 * width * p.entries();
  if (count > std::numeric_limits<std::int32_t>::max()) {
    throw InvalidInput("to_sparse", "nonzeros", static_cast<double>(count), "", "below 2^31");
  }
  SparseMatrix result(3 * p.rows(), 3 * p.rows());
  result.resizeNonZeros(count);
  std::int32_t at = 0;
  for (std::ptrdiff_t i = 0; i < p.rows(); ++i) {
    for (int r = 0; r < 3; ++r) {
      result.outerIndexPtr()[3 * i + r] = at;
      for (std::ptrdiff_t e = p.row_start[i]; e < p.row_start[i + 1]; ++e) {
        for (int c = 0; c < width; ++c, ++at) {
          result.innerIndexPtr()[at] = 3 * p.column[e] + first(r) + c;
          result.valuePtr()[at] = value(e, r, c);
        }
      }
    }
  }
  result.outerIndexPtr()[3 * p.rows()] = at;
  return result;
}

void multiply_threaded(RowProduct product, const NodePattern& p, const double* values, const double* x,
                       double* y) {
  for_chunks(p.rows(), BlockMatrix::chunk_rows, [&](std::ptrdiff_t begin, std::ptrdiff_t end, std::ptrdiff_t) {
    product(p.row_start.data(), p.column.data(), values, x, y, begin, end);
  });
}

}  // namespace

std::int32_t NodePattern::find(std::int32_t row, std::int32_t col) const {
  require_index("NodePattern", "row", row, rows());
  require_index("NodePattern", "row_start", row_start[row], entries() + 1);
  require_index("NodePattern", "row_start", row_start[row + 1], entries() + 1);
  const auto begin = column.begin() + row_start[row], end = column.begin() + row_start[row + 1];
  const auto at = std::lower_bound(begin, end, col);
  return at != end && *at == col ? static_cast<std::int32_t>(at - column.begin()) : -1;
}

BlockMatrix::BlockMatrix(Pattern pattern) : pattern_(checked(std::move(pattern), "BlockMatrix")) {
  values_.assign(static_cast<std::size_t>(9 * pattern_->entries()), 0.0);
}

void BlockMatrix::multiply(const Vector& x, Vector& y) const {
  check_product("BlockMatrix", rows(), x, y);
  y.resize(rows());
  multiply_threaded(row_products().blocks, *pattern_, values_.data(), x.data(), y.data());
}

Vector BlockMatrix::operator*(const Vector& x) const {
  Vector y;
  multiply(x, y);
  return y;
}

void BlockMatrix::multiply_rows(std::ptrdiff_t begin, std::ptrdiff_t end, const Vector& x, Vector& y) const {
  require_range("BlockMatrix", begin, end, pattern_->rows());
  check_product("BlockMatrix", rows(), x, y);
  require_size("BlockMatrix", "y", y.size(), rows());
  row_products().blocks(pattern_->row_start.data(), pattern_->column.data(), values_.data(), x.data(), y.data(),
                        begin, end);
}

void BlockMatrix::multiply_rows_packed(std::ptrdiff_t begin, std::ptrdiff_t end, const std::vector<double>& x,
                                       std::vector<double>& y) const {
  require_range("BlockMatrix", begin, end, pattern_->rows());
  require_size("BlockMatrix", "x", static_cast<std::ptrdiff_t>(x.size()), pack * rows());
  require_size("BlockMatrix", "y", static_cast<std::ptrdiff_t>(y.size()), pack * rows());
  row_products().blocks_packed(pattern_->row_start.data(), pattern_->column.data(), values_.data(), x.data(),
                               y.data(), begin, end);
}

SparseMatrix BlockMatrix::to_sparse() const {
  return expand(
      *pattern_, 3, [this](std::ptrdiff_t e, int r, int c) { return block(e)[3 * r + c]; }, [](int) { return 0; });
}

NodalMatrix::NodalMatrix(Pattern pattern) : pattern_(checked(std::move(pattern), "NodalMatrix")) {
  values_.assign(static_cast<std::size_t>(pattern_->entries()), 0.0);
}

void NodalMatrix::multiply(const Vector& x, Vector& y) const {
  check_product("NodalMatrix", rows(), x, y);
  y.resize(rows());
  multiply_threaded(row_products().nodal, *pattern_, values_.data(), x.data(), y.data());
}

Vector NodalMatrix::operator*(const Vector& x) const {
  Vector y;
  multiply(x, y);
  return y;
}

SparseMatrix NodalMatrix::to_sparse() const {
  return expand(
      *pattern_, 1, [this](std::ptrdiff_t e, int, int) { return values_[static_cast<std::size_t>(e)]; },
      [](int r) { return r; });
}

}  // namespace plica
