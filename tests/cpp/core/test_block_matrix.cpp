#include <doctest/doctest.h>

#include <random>
#include <set>

#include "plica/core/block_matrix.hpp"
#include "plica/core/error.hpp"
#include "plica/core/threads.hpp"

using namespace plica;

namespace {

/// n nodes, each coupled to itself and to about six others at random.
Pattern random_pattern(std::int32_t n) {
  std::mt19937 random(3);
  std::vector<std::set<std::int32_t>> rows(static_cast<std::size_t>(n));
  for (std::int32_t i = 0; i < n; ++i) {
    rows[i].insert(i);
    for (int k = 0; k < 3; ++k) {
      const auto j = static_cast<std::int32_t>(random() % static_cast<unsigned>(n));
      rows[i].insert(j);
      rows[j].insert(i);
    }
  }
  auto pattern = std::make_shared<NodePattern>();
  pattern->row_start.push_back(0);
  for (const auto& row : rows) {
    pattern->column.insert(pattern->column.end(), row.begin(), row.end());
    pattern->row_start.push_back(static_cast<std::int32_t>(pattern->column.size()));
  }
  return pattern;
}

template <typename Matrix>
Matrix random_matrix(const Pattern& pattern) {
  Matrix A(pattern);
  std::mt19937 random(4);
  std::uniform_real_distribution<double> number(-1.0, 1.0);
  for (double& value : A.values()) value = number(random);
  return A;
}

Vector random_vector(std::ptrdiff_t size) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> number(-1.0, 1.0);
  return Vector::NullaryExpr(size, [&] { return number(random); });
}

}  // namespace

TEST_CASE_TEMPLATE("a product equals Eigen's with the same matrix in scalar rows", Matrix, BlockMatrix,
                   NodalMatrix) {
  const auto A = random_matrix<Matrix>(random_pattern(700));
  const Vector x = random_vector(A.rows());
  const SparseMatrix scalar = A.to_sparse();
  CHECK(scalar.rows() == A.rows());
  const Vector expected = scalar * x;
  // Rows of some 20 terms of size one: differences of summation order are a few 1e-16.
  CHECK((A * x - expected).cwiseAbs().maxCoeff() < 1e-14);
  CHECK(expected.norm() > 1.0);
}

TEST_CASE_TEMPLATE("a product has the same bits for any number of threads", Matrix, BlockMatrix, NodalMatrix) {
  const auto A = random_matrix<Matrix>(random_pattern(1500));
  const Vector x = random_vector(A.rows());
  const Vector one = A * x;
  for (int count : {2, 4}) {
    set_threads(count);
    const Vector more = A * x;
    set_threads(1);
    CHECK((one.array() == more.array()).all());
  }
}

TEST_CASE("every vector of a packed product equals its own product") {
  const auto A = random_matrix<BlockMatrix>(random_pattern(60));
  constexpr int pack = BlockMatrix::pack;
  const Vector random = random_vector(pack * A.rows());
  const std::vector<double> x(random.begin(), random.end());
  std::vector<double> y(x.size(), 0.0);
  A.multiply_rows_packed(0, 60, x, y);
  for (int v = 0; v < pack; ++v) {
    using Lane = Eigen::Map<const Vector, 0, Eigen::InnerStride<pack>>;
    const Vector single = Lane(x.data() + v, A.rows());
    CHECK((A * single - Lane(y.data() + v, A.rows())).cwiseAbs().maxCoeff() < 1e-14);  // rounding as above
  }
}

TEST_CASE("block (i, j) of the pattern lands in rows 3 i and columns 3 j") {
  const Pattern pattern = random_pattern(20);
  BlockMatrix A(pattern);
  const std::int32_t entry = pattern->find(4, 4);
  REQUIRE(entry >= 0);
  A.block(entry)[1] = 2.5;  // row 0, column 1
  const SparseMatrix scalar = A.to_sparse();
  CHECK(scalar.coeff(12, 13) == 2.5);
  CHECK(scalar.sum() == 2.5);
}

TEST_CASE("find returns where a pair of nodes is, and -1 where it is not") {
  const Pattern pattern = random_pattern(50);
  std::ptrdiff_t found = 0;
  for (std::int32_t i = 0; i < 50; ++i) {
    for (std::int32_t j = 0; j < 50; ++j) {
      const std::int32_t at = pattern->find(i, j);
      if (at < 0) continue;
      ++found;
      CHECK(pattern->column[at] == j);
      CHECK(at >= pattern->row_start[i]);
      CHECK(at < pattern->row_start[i + 1]);
    }
  }
  CHECK(found == pattern->entries());
}

TEST_CASE("patterns without diagonal or out of order, and vectors of wrong length, are refused") {
  const auto make = [](std::vector<std::int32_t> rows, std::vector<std::int32_t> columns) {
    return std::make_shared<NodePattern>(NodePattern{std::move(rows), std::move(columns)});
  };
  CHECK_THROWS_AS(BlockMatrix(nullptr), InvalidInput);
  CHECK_THROWS_WITH_AS(BlockMatrix(make({0, 1, 2}, {0, 0})), doctest::Contains("pattern row = 1"), InvalidInput);
  CHECK_THROWS_AS(BlockMatrix(make({0, 2, 3}, {1, 0, 1})), InvalidInput);
  CHECK_THROWS_AS(BlockMatrix(make({0, 1, 3}, {0, 1, 2})), InvalidInput);
  CHECK_THROWS_AS(NodalMatrix(make({0, 1, 3}, {0, 1})), InvalidInput);
  const BlockMatrix A(make({0, 2, 4}, {0, 1, 0, 1}));
  CHECK_THROWS_WITH_AS(A * Vector::Ones(5), "BlockMatrix: size of x = 5; must be 6.", InvalidInput);
  Vector x = Vector::Ones(6);
  CHECK_THROWS_AS(A.multiply(x, x), InvalidInput);
}
