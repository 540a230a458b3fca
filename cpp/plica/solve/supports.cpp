#include "plica/solve/supports.hpp"

#include <algorithm>

#include "plica/core/error.hpp"

namespace plica {

Supports::Supports(std::ptrdiff_t nodes) {
  if (nodes < 0) throw InvalidInput("Supports", "nodes", static_cast<double>(nodes), "", ">= 0");
  fixed_.assign(static_cast<std::size_t>(3 * nodes), 0);
}

void Supports::fix(std::int32_t node) {
  for (int component = 0; component < 3; ++component) fix(node, component);
}

void Supports::fix(std::int32_t node, int component) {
  require_index("Supports", "node", node, size() / 3);
  require_index("Supports", "component", component, 3);
  fixed_[3 * static_cast<std::size_t>(node) + static_cast<std::size_t>(component)] = 1;
}

bool Supports::node_fixed(std::int32_t node) const {
  require_index("Supports", "node", node, size() / 3);
  const std::ptrdiff_t first = 3 * static_cast<std::ptrdiff_t>(node);
  return held(first) && held(first + 1) && held(first + 2);
}

std::ptrdiff_t Supports::fixed_count() const { return std::count(fixed_.begin(), fixed_.end(), std::uint8_t{1}); }

void Supports::project(Vector& v) const {
  require_size("Supports", "v", v.size(), size());
  for (std::ptrdiff_t i = 0; i < size(); ++i) {
    if (held(i)) v[i] = 0.0;
  }
}

void Supports::constrain(BlockMatrix& A) const {
  require_size("Supports", "the rows of A", A.rows(), size());
  const NodePattern& p = *A.pattern();
  double sum = 0.0;
  std::ptrdiff_t free = 0;
  for (std::ptrdiff_t i = 0; i < size(); ++i) {
    if (held(i)) continue;
    const auto node = static_cast<std::int32_t>(i / 3);
    sum += A.block(p.find(node, node))[4 * (i % 3)];
    ++free;
  }
  const double diagonal = free > 0 ? sum / static_cast<double>(free) : 1.0;
  for (std::ptrdiff_t i = 0; i < p.rows(); ++i) {
    for (std::ptrdiff_t e = p.row_start[i]; e < p.row_start[i + 1]; ++e) {
      for (int r = 0; r < 3; ++r) {
        for (int c = 0; c < 3; ++c) {
          const std::ptrdiff_t row = 3 * i + r, col = 3 * static_cast<std::ptrdiff_t>(p.column[e]) + c;
          if (held(row) || held(col)) A.block(e)[3 * r + c] = row == col ? diagonal : 0.0;
        }
      }
    }
  }
}

}  // namespace plica
