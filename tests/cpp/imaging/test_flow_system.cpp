#include <doctest/doctest.h>

#include <Eigen/Dense>

#include "pictures.hpp"
#include "plica/core/threads.hpp"
#include "plica/imaging/flow_system.hpp"

using namespace plica;
using namespace plica::imaging;

namespace {

struct Case {
  std::vector<Linearisation> data;
  Plane u, v;

  Case(std::ptrdiff_t rows, std::ptrdiff_t columns, unsigned channels = 1)
      : u(noise(rows, columns, 0.3F, 5)), v(noise(rows, columns, 0.3F, 6)) {
    for (unsigned k = 0; k < channels; ++k) {
      data.push_back({noise(rows, columns, 20, 10 * k + 1), noise(rows, columns, 20, 10 * k + 2),
                      noise(rows, columns, 15, 10 * k + 3), noise(rows, columns, 1, 4).abs()});
      data[k].trust(1, 2) = data[k].trust(2, 2) = 0;
    }
  }
};

/// rho of alpha e^2 / q^2 + (1 - alpha) times log(1 + e^2 / (2 s^2)) or sqrt(1 + e^2 / s^2), and its weight.
struct Mixed {
  double alpha, q, s;
  bool rooted = false;

  double operator()(double e) const {
    return alpha * e * e / (q * q) +
           (1 - alpha) * (rooted ? std::sqrt(1 + e * e / (s * s)) : std::log1p(e * e / (2 * s * s)));
  }
  Weight weight() const {
    if (rooted) {
      return {static_cast<float>(2 * alpha / (q * q)), static_cast<float>((1 - alpha) / s),
              static_cast<float>(s * s), true};
    }
    return {static_cast<float>(2 * alpha / (q * q)), static_cast<float>(2 * (1 - alpha)),
            static_cast<float>(2 * s * s)};
  }
};

/// The energy with the linearised data term, written out: E(u, v) about (u0, v0) = (c.u, c.v).
double energy(const Case& c, const Plane& u, const Plane& v, const Mixed& data, const Mixed& smooth,
              double lambda) {
  double sum = 0;
  for (std::ptrdiff_t y = 0; y < u.rows(); ++y) {
    for (std::ptrdiff_t x = 0; x < u.cols(); ++x) {
      for (const Linearisation& channel : c.data) {
        const double e = double(channel.it(y, x)) +
                         double(channel.ix(y, x)) * (double(u(y, x)) - double(c.u(y, x))) +
                         double(channel.iy(y, x)) * (double(v(y, x)) - double(c.v(y, x)));
        sum += double(channel.trust(y, x)) * data(e);
      }
      for (const Plane* f : {&u, &v}) {
        if (x + 1 < u.cols()) sum += lambda * smooth(double((*f)(y, x + 1)) - double((*f)(y, x)));
        if (y + 1 < u.rows()) sum += lambda * smooth(double((*f)(y + 1, x)) - double((*f)(y, x)));
      }
    }
  }
  return sum;
}

/// Largest derivative of the energy by central differences.
double slope(const Case& c, Plane u, Plane v, const Mixed& data, const Mixed& smooth, double lambda) {
  constexpr float h = 1.0F / 512;
  double worst = 0;
  for (Plane* f : {&u, &v}) {
    for (float& value : f->reshaped()) {
      const float kept = value;
      value = kept + h;
      const double step = double(value) - double(kept), above = energy(c, u, v, data, smooth, lambda);
      value = kept - h;
      worst = std::max(worst, std::abs(above - energy(c, u, v, data, smooth, lambda)) / (2 * step));
      value = kept;
    }
  }
  return worst;
}

}  // namespace

TEST_CASE("reweighted solves come to rest where the energy's finite differences vanish") {
  const Mixed stages[][2] = {{{1, 35, 3.5}, {1, 1, 0.1}},
                             {{0.5, 35, 3.5}, {0.5, 1, 0.1}},
                             {{0, 35, 3.5}, {0, 1, 0.1}},
                             {{0, 35, 3.5}, {1, 1, 0.1}},
                             {{0.5, 35, 3.5, true}, {0.5, 1, 0.1, true}},
                             {{0, 35, 3.5, true}, {0, 1, 0.1, true}}};
  for (std::size_t k = 0; k < std::size(stages); ++k) {
    const auto& [data, smooth] = stages[k];
    Case c(7, 6, k % 2 + 1);
    const double lambda = 0.3, before = slope(c, c.u, c.v, data, smooth, lambda);
    Plane u, v;
    for (int solve = 0; solve < 300; ++solve) {
      FlowSystem system(7, 6);
      system.assemble(c.data, c.u, c.v, data.weight(), smooth.weight(), static_cast<float>(lambda));
      system.sweep(40, 1.5F);
      system.read(u, v);
      // The same linear data term, about the new flow.
      for (Linearisation& channel : c.data) channel.it += channel.ix * (u - c.u) + channel.iy * (v - c.v);
      c.u = u;
      c.v = v;
    }
    const double after = slope(c, c.u, c.v, data, smooth, lambda);
    CHECK(before > 0.1);
    CHECK(after < 2e-3 * before);  // single precision, and h^2 of the differences
  }
}

TEST_CASE("successive over-relaxation goes to the solution of the dense equations") {
  const std::ptrdiff_t sizes[][2] = {{6, 5}, {5, 8}, {43, 4}};
  for (const auto& size : sizes) {
    const std::ptrdiff_t rows = size[0], columns = size[1], n = rows * columns;
    const Case c(rows, columns, rows == 5 ? 2 : 1);
    const Mixed data{0.5, 35, 3.5}, smooth{0.5, 1, 0.1};
    const double lambda = 0.045;
    const auto weight = [](const Mixed& m, double e) {
      return 2 * m.alpha / (m.q * m.q) + 2 * (1 - m.alpha) / (2 * m.s * m.s + e * e);
    };
    Eigen::MatrixXd A = Eigen::MatrixXd::Zero(2 * n, 2 * n);
    Eigen::VectorXd b = Eigen::VectorXd::Zero(2 * n);
    for (std::ptrdiff_t y = 0; y < rows; ++y) {
      for (std::ptrdiff_t x = 0; x < columns; ++x) {
        const std::ptrdiff_t i = y * columns + x;
        for (const Linearisation& channel : c.data) {
          const double ix = double(channel.ix(y, x)), iy = double(channel.iy(y, x)), it = double(channel.it(y, x));
          const double w = double(channel.trust(y, x)) * weight(data, it);
          const double e0 = ix * double(c.u(y, x)) + iy * double(c.v(y, x)) - it;
          A(i, i) += w * ix * ix;
          A(i, n + i) += w * ix * iy;
          A(n + i, i) += w * ix * iy;
          A(n + i, n + i) += w * iy * iy;
          b(i) += w * ix * e0;
          b(n + i) += w * iy * e0;
        }
        for (const auto& [j, inside] : {std::pair{i + 1, x + 1 < columns}, std::pair{i + columns, y + 1 < rows}}) {
          if (!inside) continue;
          for (const std::ptrdiff_t shift : {std::ptrdiff_t{0}, n}) {
            const Plane& f = shift == 0 ? c.u : c.v;
            const double s = lambda * weight(smooth, double(f.data()[j]) - double(f.data()[i]));
            A(shift + i, shift + i) += s;
            A(shift + j, shift + j) += s;
            A(shift + i, shift + j) -= s;
            A(shift + j, shift + i) -= s;
          }
        }
      }
    }
    const Eigen::VectorXd exact = A.ldlt().solve(b);
    FlowSystem system(rows, columns);
    system.assemble(c.data, c.u, c.v, data.weight(), smooth.weight(), static_cast<float>(lambda));
    system.sweep(203, 1.5F);
    Plane u, v;
    system.read(u, v);
    double worst = 0;
    for (std::ptrdiff_t i = 0; i < n; ++i) {
      worst = std::max(
          {worst, std::abs(double(u.data()[i]) - exact(i)), std::abs(double(v.data()[i]) - exact(n + i))});
    }
    CHECK(exact.cwiseAbs().maxCoeff() > 0.3);
    CHECK(worst < 1e-5);
  }
}

TEST_CASE("sweeps have the same bits for any number of threads") {
  const Case c(130, 301);
  const Mixed data{0, 35, 3.5}, smooth{0, 1, 0.1};
  FlowSystem together(130, 301), alone(130, 301);
  for (FlowSystem* system : {&together, &alone}) {
    set_threads(system == &together ? 3 : 1);
    system->assemble(c.data, c.u, c.v, data.weight(), smooth.weight(), 0.1F);
    system->sweep(23, 1.9F);
  }
  Plane u, v, other_u, other_v;
  together.read(u, v);
  alone.read(other_u, other_v);
  CHECK((u != c.u).any());
  CHECK((u == other_u).all());
  CHECK((v == other_v).all());
}
