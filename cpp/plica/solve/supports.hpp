#pragma once
#include "plica/core/block_matrix.hpp"
#include "plica/core/require.hpp"

namespace plica {

/// Which of the (3 n) unknowns are held at zero displacement.
class Supports {
 public:
  explicit Supports(std::ptrdiff_t nodes);
  void fix(std::int32_t node);                 // all three components
  void fix(std::int32_t node, int component);  // 0 x, 1 y, 2 z
  bool fixed(std::ptrdiff_t unknown) const {
    require_index("Supports", "unknown", unknown, size());
    return held(unknown);
  }
  bool node_fixed(std::int32_t node) const;  // all three
  std::ptrdiff_t fixed_count() const;
  std::ptrdiff_t size() const { return static_cast<std::ptrdiff_t>(fixed_.size()); }
  /// Sets the held entries of v (3 n) to zero.
  void project(Vector& v) const;
  /// Replaces rows and columns of held unknowns by those of the identity times the mean diagonal.
  void constrain(BlockMatrix& A) const;

 private:
  bool held(std::ptrdiff_t unknown) const { return fixed_[static_cast<std::size_t>(unknown)] != 0; }

  std::vector<std::uint8_t> fixed_;
};

}  // namespace plica
