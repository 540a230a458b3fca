#pragma once
#include <cstddef>
#include <cstdint>

namespace plica {

/// The rows [begin, end) of a product of a matrix in compressed rows with x, into y.
using RowProduct = void (*)(const std::int32_t* row_start, const std::int32_t* column, const double* values,
                            const double* x, double* y, std::ptrdiff_t begin, std::ptrdiff_t end);

/// The same with the matrix rounded to single precision; x, y and the sums stay double.
using SingleRowProduct = void (*)(const std::int32_t* row_start, const std::int32_t* column, const float* values,
                                  const double* x, double* y, std::ptrdiff_t begin, std::ptrdiff_t end);

/// The sparse products, each in the version for the processor at hand (fused multiply-add where it has it:
/// results may differ in the last digit between processors, not between runs).
struct RowProducts {
  RowProduct blocks;               // 3x3 blocks, one vector
  RowProduct blocks_packed;        // 3x3 blocks, BlockMatrix::pack interleaved vectors
  RowProduct nodal;                // numbers times I3, one vector
  SingleRowProduct blocks_single;  // 3x3 blocks in single precision, one vector: 40 bytes an entry
};

const RowProducts& row_products();

}  // namespace plica
