#include "plica/contact/row.hpp"

namespace plica {

Vector free_gaps(const std::vector<Row>& rows) {
  Vector free(static_cast<std::ptrdiff_t>(rows.size()));
  for (std::size_t i = 0; i < rows.size(); ++i) free[static_cast<std::ptrdiff_t>(i)] = rows[i].free;
  return free;
}

std::vector<Row> without_held(std::vector<Row> rows, const Supports& supports) {
  for (Row& row : rows)
    for (auto* side : {&row.push, &row.gap})
      for (auto& [node, vector] : *side)
        for (int c = 0; c < 3; ++c)
          if (supports.fixed(3 * node + c)) vector[c] = 0.0;
  return rows;
}

}  // namespace plica
