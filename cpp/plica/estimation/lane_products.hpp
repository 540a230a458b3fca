#pragma once
#include <cstddef>
#include <cstdint>

namespace plica::estimation {

/// Rows of products of matrices of 3 x 3 blocks with `lanes` vectors at once, x[lanes * unknown + lane]; every
/// lane takes the same arithmetic. One kernel goes through the pattern once for all that a time step asks of it.
struct LaneProducts {
  struct Matrices {
    const std::int32_t *row_start, *column;
    const double *K, *C, *A;  // of one pattern; C may be null
  };
  /// b = free (source - K U - C V) in the node rows [begin, end); free (3 n) is 1 or, where an unknown is held, 0.
  /// squares: |b|^2 of each lane.
  struct Force {
    const double *U, *V, *source, *free;
    double* b;
  };
  using ForceRows = void (*)(const Matrices& m, const Force& of, std::ptrdiff_t begin, std::ptrdiff_t end,
                             double* squares);
  /// r -= A d; squares: |r|^2 of each lane.
  using SubtractRows = void (*)(const Matrices& m, const double* d, double* r, std::ptrdiff_t begin,
                                std::ptrdiff_t end, double* squares);
  ForceRows force8, force16;
  SubtractRows subtract8, subtract16;
};

/// In the version for the processor at hand, as in core/block_product.hpp.
const LaneProducts& lane_products();

}  // namespace plica::estimation
