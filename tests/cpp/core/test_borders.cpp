#include "../borders.hpp"
#include "plica/core/block_matrix.hpp"
#include "plica/core/threads.hpp"

using namespace plica;
using borders::indices;
using borders::numbers;
using borders::refused;
using borders::sizes;

namespace {

/// Three nodes that all couple.
NodePattern full_pattern() { return {{0, 3, 6, 9}, {0, 1, 2, 0, 1, 2, 0, 1, 2}}; }

}  // namespace

TEST_CASE("matrices refuse patterns that are none and vectors of another size") {
  NodePattern pattern = full_pattern();
  for (const auto& [name, make] :
       {std::pair<const char*, std::function<void()>>{
            "BlockMatrix::BlockMatrix pattern", [&] { BlockMatrix(std::make_shared<NodePattern>(pattern)); }},
        {"NodalMatrix::NodalMatrix pattern", [&] { NodalMatrix(std::make_shared<NodePattern>(pattern)); }}}) {
    sizes(name, pattern.row_start, make);
    indices(name, pattern.row_start, make);
    sizes(name, pattern.column, make);
    indices(name, pattern.column, make);
  }
  refused("BlockMatrix::BlockMatrix pattern", [] { BlockMatrix(nullptr); });
  std::int32_t row = 0;
  numbers<std::int32_t>("NodePattern::find row", row, {-1, 3, 1 << 30}, [&] { pattern.find(row, 0); });
  CHECK(pattern.find(1, -1) == -1);
  CHECK(pattern.find(1, 1 << 30) == -1);
  pattern.row_start[2] = 10;
  refused("NodePattern::find row", [&] { pattern.find(1, 2); });
  refused("NodePattern::find row", [] { NodePattern().find(0, 0); });

  const auto good = std::make_shared<NodePattern>(full_pattern());
  const BlockMatrix A(good);
  const NodalMatrix M(good);
  Vector x = Vector::Ones(9), y;
  sizes("BlockMatrix::multiply x", x, [&] { A.multiply(x, y); });
  sizes("BlockMatrix::operator* x", x, [&] { A* x; });
  sizes("NodalMatrix::multiply x", x, [&] { M.multiply(x, y); });
  sizes("NodalMatrix::operator* x", x, [&] { M* x; });
  refused("BlockMatrix::multiply y", [&] { A.multiply(x, x); });
  refused("NodalMatrix::multiply y", [&] { M.multiply(x, x); });
}

TEST_CASE("threads and chunks are one or more") {
  int count = 1;
  numbers("set_threads count", count, {0, -1, 1025}, [&] { set_threads(count); });
  std::ptrdiff_t size = 1;
  numbers<std::ptrdiff_t>("for_chunks size", size, {0, -1},
                          [&] { for_chunks(4, size, [](std::ptrdiff_t, std::ptrdiff_t, std::ptrdiff_t) {}); });
}
