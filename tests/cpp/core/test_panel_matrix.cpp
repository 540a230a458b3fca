#include <doctest/doctest.h>

#include <random>

#include "../approx.hpp"
#include "plica/core/panel_matrix.hpp"

using namespace plica;

TEST_CASE("a panel matrix has the products of its matrix, whatever its size") {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  for (const std::ptrdiff_t rows : {0, 1, 15, 16, 17, 64, 101})
    for (const std::ptrdiff_t columns : {1, 2, 7, 40}) {
      const Eigen::MatrixXd A = Eigen::MatrixXd::NullaryExpr(rows, columns, [&] { return normal(random); });
      const Vector x = Vector::NullaryExpr(columns, [&] { return normal(random); });
      const PanelMatrix panels(A);
      CHECK(panels.rows() == rows);
      CHECK(panels.cols() == columns);
      const Vector expected = A * x;
      CHECK((panels * x).size() == rows);
      CHECK((panels * x - expected).norm() <= 1e-14 * (A.cwiseAbs() * x.cwiseAbs()).norm());
      const TwoColumns both = TwoColumns::NullaryExpr(columns, 2, [&] { return normal(random); });
      const Eigen::MatrixXd products = A * both;
      CHECK((panels * both).rows() == rows);
      CHECK((panels * both - products).norm() <= 1e-14 * (A.cwiseAbs() * both.cwiseAbs()).norm());
      for (std::ptrdiff_t i = 0; i < rows; ++i) {
        const Vector row = A.row(i);
        CHECK(inner_product(row, x) == approx(expected[i]).epsilon(1e-13));
      }
    }
}

TEST_CASE("a single-precision panel matrix has the products of its matrix to that precision") {
  const Eigen::MatrixXd A = Eigen::MatrixXd::Random(37, 23);
  const Vector x = Vector::Random(23);
  const SinglePanelMatrix panels(A);
  const Vector found = (panels * x.cast<float>()).cast<double>();
  CHECK((found - A * x).cwiseAbs().maxCoeff() < 1e-6);
  CHECK(found != A * x);
}

TEST_CASE("sparse panels have the products of their matrix, whatever its columns") {
  std::mt19937 random(5);
  for (const std::ptrdiff_t rows : {0, 1, 16, 40}) {
    Eigen::MatrixXd A = Eigen::MatrixXd::Zero(rows, 30);
    std::vector<SparsePanels::Entry> entries;
    for (int k = 0; k < 5 * rows; ++k) {
      const auto row = static_cast<std::int32_t>(random() % static_cast<unsigned>(rows));
      const auto column = static_cast<std::int32_t>(random() % 30);
      if (row / 16 == 1) continue;  // a panel without any
      entries.push_back({row, column, static_cast<double>(k % 7) - 2.5});
      A(row, column) += entries.back().value;
    }
    const Vector x = Vector::Random(30);
    const SparsePanels panels(rows, entries);
    CHECK(panels.rows() == rows);
    CHECK((panels * x).size() == rows);
    CHECK((panels * x - A * x).norm() <= 1e-14 * (A.cwiseAbs() * x.cwiseAbs()).norm());
  }
}
