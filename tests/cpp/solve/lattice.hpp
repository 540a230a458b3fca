#pragma once
// A cube of nodes joined by springs to their 26 neighbours and each held by a weak spring of its own:
// a symmetric positive definite block matrix with full 3x3 blocks.
#include <Eigen/Geometry>
#include <random>

#include "plica/core/block_matrix.hpp"

namespace plica_test {

inline plica::BlockMatrix spring_lattice(int side, double ground = 0.05, unsigned seed = 1) {
  using namespace plica;
  auto pattern = std::make_shared<NodePattern>();
  pattern->row_start.push_back(0);
  const auto visit = [side](int node, const auto& act) {
    const int i = node / (side * side), j = node / side % side, k = node % side;
    for (int a = std::max(i - 1, 0); a <= std::min(i + 1, side - 1); ++a) {
      for (int b = std::max(j - 1, 0); b <= std::min(j + 1, side - 1); ++b) {
        for (int c = std::max(k - 1, 0); c <= std::min(k + 1, side - 1); ++c) {
          act((a * side + b) * side + c, Vector3(a - i, b - j, c - k));
        }
      }
    }
  };
  const int nodes = side * side * side;
  for (int node = 0; node < nodes; ++node) {
    visit(node, [&](int other, const Vector3&) { pattern->column.push_back(other); });
    pattern->row_start.push_back(static_cast<std::int32_t>(pattern->column.size()));
  }
  BlockMatrix A(pattern);
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> stiffness(0.5, 2.0);
  using Block = Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>;
  for (int node = 0; node < nodes; ++node) {
    Block(A.block(pattern->find(node, node))) += ground * Matrix3::Identity();
    visit(node, [&](int other, const Vector3& offset) {
      if (other <= node) return;
      const Vector3 d = offset.normalized();
      const Matrix3 spring = stiffness(random) * (d * d.transpose() + 0.1 * Matrix3::Identity());
      Block(A.block(pattern->find(node, node))) += spring;
      Block(A.block(pattern->find(other, other))) += spring;
      Block(A.block(pattern->find(node, other))) -= spring;
      Block(A.block(pattern->find(other, node))) -= spring;
    });
  }
  return A;
}

inline plica::Vector random_vector(std::ptrdiff_t size, unsigned seed = 7) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> number(-1.0, 1.0);
  return plica::Vector::NullaryExpr(size, [&] { return number(random); });
}

}  // namespace plica_test
