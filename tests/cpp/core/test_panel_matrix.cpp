#include <doctest/doctest.h>

#include <random>

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
      for (std::ptrdiff_t i = 0; i < rows; ++i) {
        const Vector row = A.row(i);
        CHECK(inner_product(row.data(), x.data(), columns) == doctest::Approx(expected[i]).epsilon(1e-13));
      }
    }
}
