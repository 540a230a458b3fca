#include <utility>

#include "../borders.hpp"
#include "plica/core/block_matrix.hpp"
#include "plica/core/panel_matrix.hpp"
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

TEST_CASE("products of some rows refuse rows that are not there and vectors of another size") {
  const BlockMatrix A(std::make_shared<NodePattern>(full_pattern()));
  std::ptrdiff_t begin = 1, end = 2;
  Vector x = Vector::Ones(9), y = x;
  const auto rows = [&] { A.multiply_rows(begin, end, x, y); };
  std::vector<double> many(9 * BlockMatrix::pack, 1.0), products = many;
  const auto packed = [&] { A.multiply_rows_packed(begin, end, many, products); };
  numbers<std::ptrdiff_t>("BlockMatrix::multiply_rows begin", begin, {-1, 3, 4, 1 << 30}, rows);
  numbers<std::ptrdiff_t>("BlockMatrix::multiply_rows end", end, {-1, 0, 4, 1 << 30}, rows);
  sizes("BlockMatrix::multiply_rows x", x, rows);
  sizes("BlockMatrix::multiply_rows y", y, rows);
  refused("BlockMatrix::multiply_rows y", [&] { A.multiply_rows(begin, end, x, x); });
  numbers<std::ptrdiff_t>("BlockMatrix::multiply_rows_packed begin", begin, {-1, 3, 4, 1 << 30}, packed);
  numbers<std::ptrdiff_t>("BlockMatrix::multiply_rows_packed end", end, {-1, 0, 4, 1 << 30}, packed);
  sizes("BlockMatrix::multiply_rows_packed x", many, packed);
  sizes("BlockMatrix::multiply_rows_packed y", products, packed);
}

TEST_CASE("views and inner products refuse vectors that do not fit") {
  Vector v = Vector::Ones(6);
  for (const std::ptrdiff_t size : {1, 2, 4, 5, 7}) {
    v = Vector::Ones(size);
    refused("as_points v", [&] { as_points(v); });
    refused("as_points v", [&] { as_points(std::as_const(v)); });
  }
  CHECK(as_points(Vector()).rows() == 0);
  Vector a = Vector::Ones(6), b = a;
  sizes("inner_product a", a, [&] { inner_product(a, b); });
  sizes("inner_product b", b, [&] { inner_product(a, b); });
}

TEST_CASE("an index is below its count, a range of rows within it, and rows are whole") {
  const auto index = [](std::ptrdiff_t i) { require_index("here", "i", i, 3); };
  const auto all = [](std::int32_t i) { require_indices("here", "i", std::vector<std::int32_t>{2, i, 0}, 3); };
  for (const std::int32_t i : {0, 1, 2}) {
    CHECK_NOTHROW(index(i));
    CHECK_NOTHROW(all(i));
  }
  for (const std::int32_t i : {-1, 3, 4}) {
    CHECK_THROWS_AS(index(i), InvalidInput);
    CHECK_THROWS_WITH_AS(all(i), ("here: i = " + std::to_string(i) + "; must be in [0, 3).").c_str(),
                         InvalidInput);
  }
  for (int begin = -1; begin < 5; ++begin)
    for (int end = -1; end < 5; ++end) {
      CAPTURE(begin);
      CAPTURE(end);
      const auto range = [&] { require_range("here", begin, end, 3); };
      if (0 <= begin && begin <= end && end <= 3)
        CHECK_NOTHROW(range());
      else
        CHECK_THROWS_AS(range(), InvalidInput);
    }
  for (const std::ptrdiff_t size : {0, 3, 6}) CHECK_NOTHROW(require_rows("here", "v", size, 3));
  for (const std::ptrdiff_t size : {1, 2, 4, 5}) CHECK_THROWS_AS(require_rows("here", "v", size, 3), InvalidInput);
  CHECK_NOTHROW(require_at_least("here", "v", 3, 3));
  CHECK_THROWS_AS(require_at_least("here", "v", 2, 3), InvalidInput);
  CHECK_THROWS_AS(require_size("here", "v", 4, 3, 5), InvalidInput);
}

TEST_CASE("threads and chunks are one or more") {
  int count = 1;
  numbers("set_threads count", count, {0, -1, 1025}, [&] { set_threads(count); });
  std::ptrdiff_t size = 1;
  numbers<std::ptrdiff_t>("for_chunks size", size, {0, -1},
                          [&] { for_chunks(4, size, [](std::ptrdiff_t, std::ptrdiff_t, std::ptrdiff_t) {}); });
}
