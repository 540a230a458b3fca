// Strains against closed forms, a second algorithm, and for any number of threads.
#include <doctest/doctest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "../approx.hpp"
#include "plica/core/error.hpp"
#include "plica/core/threads.hpp"
#include "plica/tissue/element.hpp"
#include "plica/tissue/strain.hpp"
#include "scenes.hpp"

using namespace plica;
using scenes::Distorted;
using scenes::Kind;

namespace {

// Eigen's direct solver loses half of the digits where eigenvalues are double.
constexpr double tolerance = 1e-7;

double norm(const Matrix3& A) { return Eigen::JacobiSVD<Matrix3>(A).singularValues()[0]; }

template <class Field>
Vector displaced(const TetMesh& mesh, const Field& field) {
  Vector u(3 * mesh.node_count());
  for (std::ptrdiff_t i = 0; i < mesh.node_count(); ++i)
    u.segment<3>(3 * i) = field(Vector3(mesh.points.row(i).transpose()));
  return u;
}

Matrix3 gradient_at(const TetMesh& mesh, const Vector& u, std::ptrdiff_t c, const std::array<double, 4>& at) {
  Element element(mesh.order());
  element.place(mesh.points, mesh.cells.row(c).data());
  const auto g = element.gradients(at);
  Matrix3 H = Matrix3::Zero();
  for (int a = 0; a < element.nodes(); ++a) H += u.segment<3>(3 * mesh.cells(c, a)) * g.row(a);
  return H;
}

}  // namespace

TEST_CASE("an affine displacement has its one strain, and leaves out half the square of its gradient") {
  Matrix3 H;
  H << 0.1, 0.2, -0.3, 0.05, -0.2, 0.1, 0.4, 0.3, 0.2;
  for (const Kind kind : scenes::kinds) {
    CAPTURE(static_cast<int>(kind));
    const Distorted scene(kind);
    for (const Matrix3& G :
         {H, Matrix3(-H), Matrix3(H.transpose()), scenes::unit_strain(1), scenes::unit_strain(4)}) {
      const Strains found = StrainGauge(scene.mesh).measure(scenes::affine_displacement(scene.mesh, G));
      const double strain = norm(0.5 * (G + G.transpose()));
      CHECK(found.strain == approx(strain).epsilon(tolerance));
      CHECK(found.largest == approx(strain).epsilon(tolerance));
      CHECK(found.neglected == approx(0.5 * norm(G) * norm(G)).epsilon(tolerance));
      // |E - eps| from its definition.
      const Matrix3 F = Matrix3::Identity() + G;
      const Matrix3 E = 0.5 * (F.transpose() * F - Matrix3::Identity());
      CHECK(found.neglected == approx(norm(E - 0.5 * (G + G.transpose()))).epsilon(tolerance));
    }
  }
}

TEST_CASE("of a rotation all small strain is wrong: 1 - cos(angle), and as much is left out") {
  for (const Kind kind : scenes::kinds) {
    CAPTURE(static_cast<int>(kind));
    const Distorted scene(kind);
    for (const double angle : {1e-3, 0.1, 0.5, 2.0}) {
      CAPTURE(angle);
      const Matrix3 R = Eigen::AngleAxisd(angle, Vector3(1, -2, 3).normalized()).toRotationMatrix();
      const Strains found =
          StrainGauge(scene.mesh).measure(scenes::affine_displacement(scene.mesh, R - Matrix3::Identity()));
      const double wrong = 2 * std::pow(std::sin(angle / 2), 2);
      CHECK(found.strain == approx(wrong).epsilon(tolerance));
      CHECK(found.neglected == approx(wrong).epsilon(tolerance));
    }
  }
}

TEST_CASE("a bent block has the strain of beams, read where a quadratic cell has it exactly") {
  // u = k (x z, 0, -x^2/2): eps = k z in x alone, rotation k x; |grad u|^2 from the 2 x 2 block [k z, k x; -k x,
  // 0].
  const double k = 0.1, height = 1.0, length = 4.0;
  const int layers = 8;
  const TetMesh linear =
      block_mesh(Block{{-length / 2, 0.0, -height / 2}, {length, 0.5, height}, {16, 1, layers}});
  const TetMesh mesh = to_quadratic(linear);
  const Vector u =
      displaced(mesh, [&](const Vector3& x) { return Vector3(k * x[0] * x[2], 0, -0.5 * k * x[0] * x[0]); });
  const Strains found = StrainGauge(mesh).measure(u);
  CHECK(found.strain == approx(k * std::abs(found.place[2])).epsilon(tolerance));
  CHECK(found.largest == approx(k * std::abs(found.place[2])).epsilon(tolerance));
  // The outermost points lie 0.1382 of a layer beneath the surface, that of more than 0.1 % of the volume.
  const double depth = 0.25 * (1 - 1 / std::sqrt(5.0)) * height / layers;
  CHECK(found.strain == approx(k * (height / 2 - depth)).epsilon(tolerance));
  const auto& rule = tetrahedron_rule_degree_2();
  std::vector<std::pair<double, double>> neglected;  // and volume
  for (std::ptrdiff_t c = 0; c < mesh.cell_count(); ++c) {
    const double volume = signed_volumes(mesh.points, mesh.cells.row(c))[0] / 4;
    for (const auto& point : rule) {
      Vector3 x = Vector3::Zero();
      for (int a = 0; a < 4; ++a)
        x += point.at[static_cast<std::size_t>(a)] * mesh.points.row(mesh.cells(c, a)).transpose();
      // Largest eigenvalue of H^T H: trace k^2 (z^2 + 2 x^2), determinant k^4 x^4.
      const double s = x[2] * x[2] + 2 * x[0] * x[0], t = std::pow(x[0], 4);
      neglected.emplace_back(0.5 * k * k * (s + std::sqrt(std::max(0.0, s * s - 4 * t))) / 2, volume);
    }
  }
  const StrainGauge gauge(mesh);
  const Vector at_points = gauge.at_points(u), volumes = gauge.volumes();
  REQUIRE(at_points.size() == 4 * mesh.cell_count());
  CHECK(volumes.sum() == approx(length * height * 0.5).epsilon(tolerance));
  for (std::ptrdiff_t c = 0; c < mesh.cell_count(); ++c)
    for (std::ptrdiff_t p = 0; p < 4; ++p) {
      Vector3 x = Vector3::Zero();
      for (int a = 0; a < 4; ++a)
        x += rule[static_cast<std::size_t>(p)].at[static_cast<std::size_t>(a)] *
             mesh.points.row(mesh.cells(c, a)).transpose();
      CHECK(std::abs(at_points[4 * c + p] - k * std::abs(x[2])) < tolerance);
      CHECK(volumes[4 * c + p] ==
            approx(signed_volumes(mesh.points, mesh.cells.row(c))[0] / 4).epsilon(tolerance));
    }
  std::sort(neglected.rbegin(), neglected.rend());
  double volume = 0;
  std::size_t i = 0;
  while ((volume += neglected[i].second) <= 1e-3 * length * height * 0.5) ++i;
  CHECK(found.neglected == approx(neglected[i].first).epsilon(tolerance));
}

TEST_CASE("a percentile is one by volume: a thin slab counts once it is 0.1 % of the block") {
  for (const int order : {1, 2}) {
    for (const double share : {0.5e-3, 1.5e-3}) {
      CAPTURE(order);
      CAPTURE(share);
      TetMesh mesh = block_mesh(Block{{0, 0, 0}, {4, 1, 1}, {4, 3, 3}});
      for (std::ptrdiff_t i = 0; i < mesh.node_count(); ++i)  // the last slab is so thin
        if (mesh.points(i, 0) > 2.5 && mesh.points(i, 0) < 3.5) mesh.points(i, 0) = 4 * (1 - share);
      if (order == 2) mesh = to_quadratic(mesh);
      const Vector u = displaced(mesh, [&](const Vector3& x) {
        const double beyond = std::max(0.0, x[0] - 4 * (1 - share));
        return Vector3(0.1 * x[0] + 0.2 * beyond, 0, 0);
      });
      const Strains found = StrainGauge(mesh).measure(u);
      CHECK(found.largest == approx(0.3).epsilon(tolerance));
      CHECK(found.strain == approx(share > 1e-3 ? 0.3 : 0.1).epsilon(tolerance));
      CHECK(found.place[0] > 4 * (1 - share));
    }
  }
}

TEST_CASE("the strains of all points have the percentile and the largest that are measured") {
  for (const StrainMeasure measure : {StrainMeasure::small, StrainMeasure::green})
    for (const int order : {1, 2}) {
      CAPTURE(order);
      TetMesh mesh = block_mesh(Block{{0, 0, 0}, {1, 1, 1}, {6, 6, 6}});
      if (order == 2) mesh = to_quadratic(mesh);
      const Vector u =
          displaced(mesh, [&](const Vector3& x) { return Vector3(0.2 * x[0] * x[1], x[2] * x[2], 0.3 * x[0]); });
      StrainGauge gauge(mesh, measure);
      const Strains found = gauge.measure(u);
      const Vector strain = gauge.at_points(u), volume = gauge.volumes();
      std::vector<std::ptrdiff_t> order_of(static_cast<std::size_t>(strain.size()));
      std::iota(order_of.begin(), order_of.end(), 0);
      std::stable_sort(order_of.begin(), order_of.end(), [&](auto a, auto b) { return strain[a] > strain[b]; });
      CHECK(strain[order_of[0]] == found.largest);
      double beyond = 0;
      std::size_t i = 0;
      while ((beyond += volume[order_of[i]]) <= StrainGauge::beyond * volume.sum()) ++i;
      CHECK(strain[order_of[i]] == found.strain);
    }
}

TEST_CASE("strains are the same for any number of threads and whatever was measured before") {
  const Distorted scene(Kind::curved, 6);
  const auto wave = [&](double size) {
    return displaced(scene.mesh, [&](const Vector3& x) {
      return Vector3(size * std::sin(3 * x[1]), size * std::cos(2 * x[0] * x[2]), size * x[0] * x[1]);
    });
  };
  const auto same = [](const Strains& a, const Strains& b) {
    return a.strain == b.strain && a.neglected == b.neglected && a.largest == b.largest && a.cell == b.cell &&
           a.place == b.place;
  };
  std::vector<Strains> alone;
  const std::vector<double> sizes{0.1, 0.3, 1e-6, 0.0, 0.2, 0.19};
  for (const double size : sizes) alone.push_back(StrainGauge(scene.mesh).measure(wave(size)));
  CHECK(alone[1].strain > 2.9 * alone[0].strain);
  CHECK(alone[3].largest == 0.0);
  const int before = threads();
  for (const int count : {1, 2, 3}) {
    set_threads(count);
    StrainGauge gauge(scene.mesh);
    for (std::size_t i = 0; i < sizes.size(); ++i) CHECK(same(gauge.measure(wave(sizes[i])), alone[i]));
  }
  set_threads(before);
}

TEST_CASE("percentiles of any field are those of all points, each decomposed") {
  for (const Kind kind : scenes::kinds) {
    CAPTURE(static_cast<int>(kind));
    const Distorted scene(kind, 5);
    const Vector u = displaced(scene.mesh, [](const Vector3& x) {
      return Vector3(0.2 * std::sin(3 * x[1]), 0.1 * std::cos(2 * x[0] * x[2]), 0.3 * x[0] * x[1]);
    });
    std::vector<std::array<double, 3>> all;  // strain, gradient, volume
    double whole = 0;
    Element element(scene.mesh.order());
    for (std::ptrdiff_t c = 0; c < scene.mesh.cell_count(); ++c)
      for (const auto& point : tetrahedron_rule_degree_2()) {
        const Matrix3 H = gradient_at(scene.mesh, u, c, point.at);
        element.place(scene.mesh.points, scene.mesh.cells.row(c).data());
        double volume = element.volume() / 4;
        if (kind == Kind::curved) {  // det dx/dxi / 6, the inverse of dN/dx of the barycentric coordinates
          Eigen::Matrix<double, 3, 10> x;
          for (int a = 0; a < 10; ++a) x.col(a) = scene.mesh.points.row(scene.mesh.cells(c, a)).transpose();
          const Eigen::Matrix<double, 3, 4> d = x * quadratic_slopes(point.at);
          Matrix3 J;
          for (int k = 0; k < 3; ++k) J.col(k) = d.col(k + 1) - d.col(0);
          volume = J.determinant() / 24;
        }
        all.push_back({norm(0.5 * (H + H.transpose())), norm(H), volume});
        whole += volume;
      }
    const auto exceeded = [&](std::size_t which) {
      std::sort(all.begin(), all.end(), [&](const auto& a, const auto& b) { return a[which] > b[which]; });
      double volume = 0;
      std::size_t i = 0;
      while ((volume += all[i][2]) <= 1e-3 * whole) ++i;
      return all[i][which];
    };
    const Strains found = StrainGauge(scene.mesh).measure(u);
    CHECK(found.strain == approx(exceeded(0)).epsilon(tolerance));
    CHECK(found.largest == approx(all.front()[0]).epsilon(tolerance));
    CHECK(found.neglected == approx(0.5 * exceeded(1) * exceeded(1)).epsilon(tolerance));
  }
}

TEST_CASE("no cell is folded but a suspect, and of small strains there is none") {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  for (const Kind kind : scenes::kinds) {
    CAPTURE(static_cast<int>(kind));
    const Distorted scene(kind, 4);
    StrainGauge gauge(scene.mesh);
    Vector noise(3 * scene.mesh.node_count());
    for (auto& value : noise) value = normal(random);
    std::ptrdiff_t most = 0;
    for (const double size : {1e-4, 0.01, 0.02, 0.03, 0.1}) {
      CAPTURE(size);
      const Vector u = size * noise;
      gauge.measure(u);
      const Points x = scene.mesh.points + as_points(u);
      const std::ptrdiff_t folded = folded_cells(x, scene.mesh.cells);
      CHECK(folded_cells(x, scene.mesh.cells, gauge.suspects()) == folded);
      if (size < 1e-3) CHECK(gauge.suspects().empty());
      most = std::max(most, folded);
    }
    CHECK(most > scene.mesh.cell_count() / 10);
  }
}

TEST_CASE(
    "strain of a field that is no quadratic has less than half the error at the points that it has at the "
    "corners") {
  const Distorted scene(Kind::straight, 4);
  const auto field = [](const Vector3& x) {
    return Vector3(x[0] * x[0] * x[1], std::pow(x[2], 3), x[0] * x[1] * x[2]);
  };
  const auto exact = [](const Vector3& x) {
    Matrix3 H;
    H << 2 * x[0] * x[1], x[0] * x[0], 0, 0, 0, 3 * x[2] * x[2], x[1] * x[2], x[0] * x[2], x[0] * x[1];
    return H;
  };
  const Vector u = displaced(scene.mesh, field);
  const auto error = [&](const std::vector<std::array<double, 4>>& places) {
    double sum = 0;
    for (std::ptrdiff_t c = 0; c < scene.mesh.cell_count(); ++c)
      for (const auto& at : places) {
        Vector3 x = Vector3::Zero();
        for (int a = 0; a < 4; ++a)
          x += at[static_cast<std::size_t>(a)] * scene.mesh.points.row(scene.mesh.cells(c, a)).transpose();
        sum += (gradient_at(scene.mesh, u, c, at) - exact(x)).squaredNorm();
      }
    return std::sqrt(sum);
  };
  std::vector<std::array<double, 4>> points, corners;
  for (const auto& point : tetrahedron_rule_degree_2()) points.push_back(point.at);
  for (std::size_t i = 0; i < 4; ++i) {
    corners.push_back({0, 0, 0, 0});
    corners.back()[i] = 1;
  }
  CHECK(error(points) > 0);
  CHECK(error(corners) > 2.5 * error(points));
}

TEST_CASE("a displacement that is not finite is refused") {
  const TetMesh mesh = block_mesh(Block{});
  Vector u = Vector::Zero(3 * mesh.node_count());
  u[5] = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS_WITH_AS(StrainGauge(mesh).measure(u), doctest::Contains("not finite"), InvalidInput);
}
