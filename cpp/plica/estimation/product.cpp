#include "plica/estimation/product.hpp"

#include <algorithm>

#include "plica/core/require.hpp"
#include "plica/core/threads.hpp"
#include "plica/estimation/product_kernels.hpp"

namespace plica::estimation {
namespace {

constexpr std::ptrdiff_t depth_at_once = 256;  // a strip of B then stays in the first cache
constexpr std::ptrdiff_t rows_at_once = 48;    // a multiple of every tile's height; what one thread draws

std::ptrdiff_t round_up(std::ptrdiff_t n, std::ptrdiff_t to) { return (n + to - 1) / to * to; }

/// Memory of a thread that grows and stays.
double* workspace(Vector& kept, std::ptrdiff_t size) {
  if (kept.size() < size) kept.resize(size);
  return kept.data();
}

/// out[width * k + i] = m(i, k) for one strip of `width` rows, zero beyond the last.
void pack(const MatrixView& m, std::ptrdiff_t width, double* out) {
  if (m.rows < width) std::fill(out, out + width * m.columns, 0.0);
  if (m.row_stride == 1) {
    for (std::ptrdiff_t k = 0; k < m.columns; ++k) {
      const double* from = m.data + k * m.column_stride;
      std::copy(from, from + m.rows, out + width * k);
    }
    return;
  }
  // Eight columns at a time: the lines that are written stay in cache while the rows are walked.
  std::ptrdiff_t k = 0;
  if (m.column_stride == 1) {
    for (; k + 8 <= m.columns; k += 8) {
      double* const to = out + width * k;
      for (std::ptrdiff_t i = 0; i < m.rows; ++i) {
        const double* from = m.data + i * m.row_stride + k;
        for (std::ptrdiff_t q = 0; q < 8; ++q) to[width * q + i] = from[q];
      }
    }
  }
  for (; k < m.columns; ++k) {
    const double* from = m.data + k * m.column_stride;
    for (std::ptrdiff_t i = 0; i < m.rows; ++i) out[width * k + i] = from[i * m.row_stride];
  }
}

/// The rows of C from `a`, packed, times all strips of B.
void row_block(const ProductKernels& kernels, double scale, const double* a, const double* b, std::ptrdiff_t depth,
               const MatrixSpan& c, std::ptrdiff_t first_row, Part part, bool add) {
  const std::ptrdiff_t height = kernels.rows, width = kernels.columns;
  alignas(64) double edge[12 * 16];
  for (std::ptrdiff_t j = 0; j < c.columns; j += width) {
    const double* strip = b + j * depth;
    for (std::ptrdiff_t i = 0; i < c.rows; i += height) {
      if (part == Part::upper && first_row + i >= j + width) break;
      double* out = c.data + i * c.row_stride + j;
      const std::ptrdiff_t rows = std::min(height, c.rows - i), columns = std::min(width, c.columns - j);
      const std::ptrdiff_t low = 2 * rows <= height ? 1 : 0, narrow = 2 * columns <= width ? 1 : 0;
      const ProductKernels::Tile tile = kernels.tile[low][narrow];
      if (rows == height >> low && columns == width >> narrow) {
        tile(a + i * depth, strip, depth, scale, out, c.row_stride, add);
        continue;
      }
      tile(a + i * depth, strip, depth, scale, edge, width, false);
      for (std::ptrdiff_t p = 0; p < rows; ++p) {
        double* row = out + p * c.row_stride;
        for (std::ptrdiff_t q = 0; q < columns; ++q) {
          row[q] = add ? row[q] + edge[p * width + q] : edge[p * width + q];
        }
      }
    }
  }
}

}  // namespace

void multiply(double scale, const MatrixView& a, const MatrixView& b, const MatrixSpan& c, Part part, Into into) {
  require_size("multiply", "rows of b", b.rows, a.columns);
  require_size("multiply", "rows of c", c.rows, a.rows);
  require_size("multiply", "columns of c", c.columns, b.columns);
  require_rows_together("multiply", "C", c);
  const ProductKernels& kernels = product_kernels();
  const std::ptrdiff_t height = kernels.rows, width = kernels.columns;
  const std::ptrdiff_t row_blocks = (c.rows + rows_at_once - 1) / rows_at_once;
  static thread_local Vector kept_strips;
  double* const strips = workspace(kept_strips, round_up(c.columns, width) * std::min(a.columns, depth_at_once));
  if (a.columns == 0 && into == Into::overwrite) {
    for (std::ptrdiff_t i = 0; i < c.rows; ++i) std::fill_n(c.data + i * c.row_stride, c.columns, 0.0);
  }
  for (std::ptrdiff_t at = 0; at < a.columns; at += depth_at_once) {
    const std::ptrdiff_t depth = std::min(depth_at_once, a.columns - at);
    const bool add = into == Into::add || at > 0;
    for_chunks(c.columns, 8 * width, [&](std::ptrdiff_t begin, std::ptrdiff_t end, std::ptrdiff_t) {
      for (std::ptrdiff_t j = begin; j < end; j += width) {
        pack(b.block(at, j, depth, std::min(width, end - j)).transposed(), width, strips + j * depth);
      }
    });
    for_chunks(row_blocks, 1, [&](std::ptrdiff_t block, std::ptrdiff_t, std::ptrdiff_t) {
      static thread_local Vector kept_rows;
      double* const rows = workspace(kept_rows, rows_at_once * depth_at_once);
      const std::ptrdiff_t first = block * rows_at_once, count = std::min(rows_at_once, c.rows - first);
      for (std::ptrdiff_t i = 0; i < count; i += height) {
        pack(a.block(first + i, at, std::min(height, count - i), depth), height, rows + i * depth);
      }
      row_block(kernels, scale, rows, strips, depth, c.block(first, 0, count, c.columns), first, part, add);
    });
  }
}

void require_rows_together(const char* where, const char* name, const MatrixView& matrix) {
  if (matrix.columns > 1 && matrix.column_stride != 1)
    throw InvalidInput(where, std::string("column_stride of ") + name, static_cast<double>(matrix.column_stride),
                       "", "1", "The entries of a row must lie one behind the other.");
}

void mirror_upper(const MatrixSpan& a) {
  // Blocks of eight rows by eight columns, both of whose lines stay in cache.
  require_size("mirror_upper", "columns", a.columns, a.rows);
  require_rows_together("mirror_upper", "A", a);
  constexpr std::ptrdiff_t tile = 8;
  const std::ptrdiff_t n = a.rows, stride = a.row_stride;
  for (std::ptrdiff_t i = 0; i < n; i += tile) {
    const std::ptrdiff_t height = std::min(tile, n - i);
    for (std::ptrdiff_t p = i; p < i + height; ++p) {
      for (std::ptrdiff_t q = p + 1; q < i + height; ++q) a.data[q * stride + p] = a.data[p * stride + q];
    }
    if (height < tile) break;
    for (std::ptrdiff_t q = i + tile; q < n; ++q) {
      const double* const from = a.data + i * stride + q;
      double* const to = a.data + q * stride + i;
      for (std::ptrdiff_t p = 0; p < tile; ++p) to[p] = from[p * stride];
    }
  }
}

}  // namespace plica::estimation
