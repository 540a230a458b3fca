#include "plica/solve/saddle_point.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "plica/core/error.hpp"
#include "plica/core/threads.hpp"
#include "plica/solve/shared_compliance.hpp"

namespace plica {

namespace {

constexpr std::ptrdiff_t chunk_rows = BlockMatrix::chunk_rows;
constexpr double finest = 3e-3;  // a correction is asked for no more: where G differs from N it gives no more
constexpr std::size_t directions = 20;  // kept by the conjugate residuals
constexpr int patience = 8;             // directions in a row that may fail to halve the residual

double product_with(const std::vector<NodeVector>& row, const Vector& v) {
  double sum = 0.0;
  for (const auto& [node, vector] : row) sum += vector.dot(v.segment<3>(3 * node));
  return sum;
}

void add_scaled(const std::vector<NodeVector>& row, double factor, Vector& v) {
  for (const auto& [node, vector] : row) v.segment<3>(3 * node) += factor * vector;
}

/// Runs work(begin, end) -> double over all chunks of node rows; the total is taken in chunk order.
template <typename Work>
double sum_over_rows(std::ptrdiff_t rows, const Work& work) {
  Vector partial((rows + chunk_rows - 1) / chunk_rows);
  for_chunks(rows, chunk_rows, [&](std::ptrdiff_t begin, std::ptrdiff_t end, std::ptrdiff_t chunk) {
    partial[chunk] = work(begin, end);
  });
  double sum = 0.0;
  for (const double part : partial) sum += part;
  return sum;
}

}  // namespace

/// A vector of the whole system.
struct SaddlePoint::Both {
  Vector d, lambda;

  void add(double factor, const Both& other) {
    d += factor * other.d;
    lambda += factor * other.lambda;
  }
};

struct SaddlePoint::System {
  const std::vector<SaddleRow>& constraints;
  std::vector<std::vector<NodeVector>> NB;  // rows of N B
  Vector D;                                 // with the regularisation
  Vector weight;                            // 1 / diag(S)
  Eigen::LLT<Eigen::MatrixXd> S;            // N B N^T + D

  std::ptrdiff_t size() const { return D.size(); }
  const SaddleRow& operator[](std::ptrdiff_t i) const { return constraints[static_cast<std::size_t>(i)]; }

  System(const std::vector<SaddleRow>& given, const ConjugateGradient& blocks, std::ptrdiff_t unknowns)
      : constraints(given), NB(given.size()), D(static_cast<std::ptrdiff_t>(given.size())) {
    Vector column = Vector::Zero(unknowns), image = Vector::Zero(unknowns);
    Eigen::MatrixXd compliance(size(), size());
    for (std::ptrdiff_t j = 0; j < size(); ++j) {
      const std::vector<NodeVector>& push = (*this)[j].push;
      add_scaled(push, 1.0, column);
      for (const auto& [node, vector] : push) blocks.precondition_rows(node, node + 1, column, image);
      for (std::ptrdiff_t i = 0; i < size(); ++i) compliance(i, j) = product_with((*this)[i].push, image);
      for (const auto& [node, vector] : push) {
        if (column.segment<3>(3 * node).isZero(0)) continue;  // or had before in this row
        NB[static_cast<std::size_t>(j)].push_back({node, image.segment<3>(3 * node)});
        column.segment<3>(3 * node).setZero();
        image.segment<3>(3 * node).setZero();
      }
    }
    const double regularisation = shared_compliance * compliance.diagonal().maxCoeff();
    for (std::ptrdiff_t i = 0; i < size(); ++i) D[i] = regularisation + (*this)[i].compliance;
    compliance.diagonal() += D;
    weight = compliance.diagonal().cwiseInverse();
    S.compute(compliance);
    if (S.info() != Eigen::Success || !weight.allFinite())
      throw SolveFailed(
          "the compliance of the closed rows is singular. A contact between two fully fixed bodies?");
  }

  Vector N(const Vector& v) const {
    Vector out(size());
    for (std::ptrdiff_t i = 0; i < size(); ++i) out[i] = product_with((*this)[i].push, v);
    return out;
  }
  void add_NT(const Vector& lambda, Vector& v) const {
    for (std::ptrdiff_t i = 0; i < size(); ++i) add_scaled((*this)[i].push, lambda[i], v);
  }
};

SaddlePoint::SaddlePoint(const BlockMatrix& A, KrylovOptions options)
    : A_(A), blocks_(A, options), options_(options), weight_(A.rows()) {
  for (std::int32_t i = 0; i < A.rows() / 3; ++i)
    for (int c = 0; c < 3; ++c) weight_[3 * i + c] = 1.0 / A.block(A.pattern()->find(i, i))[4 * c];
}

/// x ~ [A N^T; N -D]^-1 right, to a residual of `target`; returns the products taken.
int SaddlePoint::correct(const System& system, const Both& right, Both& x, double target, bool rounded) const {
  const std::ptrdiff_t unknowns = A_.rows(), nodes = unknowns / 3;
  Vector r(unknowns), z(unknowns), p(unknowns), q(unknowns), p_lambda, z_lambda;
  const auto product = [&](std::ptrdiff_t begin, std::ptrdiff_t end, const Vector& in, Vector& out) {
    if (rounded)
      blocks_.multiply_rounded_rows(begin, end, in, out);
    else
      A_.multiply_rows(begin, end, in, out);
  };
  const auto dot_rows = [](const Vector& a, const Vector& b, std::ptrdiff_t begin, std::ptrdiff_t end) {
    return a.segment(3 * begin, 3 * (end - begin)).dot(b.segment(3 * begin, 3 * (end - begin)));
  };
  // [z; z_lambda] = P^-1 [r; -value], given z = B r
  const auto project = [&](const Vector& value) {
    z_lambda = system.S.solve(system.N(z) + value);
    for (std::ptrdiff_t i = 0; i < system.size(); ++i)
      add_scaled(system.NB[static_cast<std::size_t>(i)], -z_lambda[i], z);
  };

  // What P^-1 leaves over of `right` has no second part, nor has anything after it.
  const double size = std::sqrt(right.d.dot(weight_.cwiseProduct(right.d)) +
                                right.lambda.dot(system.weight.cwiseProduct(right.lambda)));
  blocks_.precondition(right.d, z);
  project(-right.lambda);
  x.d = z;
  x.lambda = z_lambda;
  for_chunks(nodes, chunk_rows,
             [&](std::ptrdiff_t begin, std::ptrdiff_t end, std::ptrdiff_t) { product(begin, end, x.d, q); });
  system.add_NT(x.lambda, q);
  r = right.d - q;
  const Vector nothing = Vector::Zero(system.size());
  p.setZero();
  p_lambda = nothing;
  double rz_before = 1.0, alpha = 0.0;
  q.setZero();
  int products = 1;
  for (;; ++products) {
    double rz = sum_over_rows(nodes, [&](std::ptrdiff_t begin, std::ptrdiff_t end) {
      const std::ptrdiff_t at = 3 * begin, count = 3 * (end - begin);
      x.d.segment(at, count) += alpha * p.segment(at, count);
      r.segment(at, count) -= alpha * q.segment(at, count);
      blocks_.precondition_rows(begin, end, r, z);
      return dot_rows(r, z, begin, end);
    });
    x.lambda += alpha * p_lambda;
    const Vector Nz = system.N(z);
    project(nothing);
    rz -= Nz.dot(z_lambda);
    if (!(rz > target * target * size * size) || products >= options_.max_iterations) return products;
    const double beta = products == 1 ? 0.0 : rz / rz_before;
    rz_before = rz;
    for_chunks(nodes, chunk_rows, [&](std::ptrdiff_t begin, std::ptrdiff_t end, std::ptrdiff_t) {
      const std::ptrdiff_t at = 3 * begin, count = 3 * (end - begin);
      p.segment(at, count) = z.segment(at, count) + beta * p.segment(at, count);
    });
    p_lambda = z_lambda + beta * p_lambda;
    const double pAp = sum_over_rows(nodes, [&](std::ptrdiff_t begin, std::ptrdiff_t end) {
      product(begin, end, p, q);
      return dot_rows(p, q, begin, end);
    });
    const double curvature = pAp + system.N(p).dot(p_lambda);
    system.add_NT(p_lambda, q);
    if (!(curvature > 0.0)) return products;
    alpha = rz / curvature;
  }
}

Convergence SaddlePoint::solve(const std::vector<SaddleRow>& constraints, Vector& d, Vector& lambda) const {
  const System system(constraints, blocks_, A_.rows());
  const auto apply = [&](const Both& in, Both& out) {
    A_.multiply(in.d, out.d);
    system.add_NT(in.lambda, out.d);
    out.lambda.resize(system.size());
    for (std::ptrdiff_t i = 0; i < system.size(); ++i)
      out.lambda[i] = product_with(system[i].gap, in.d) - system.D[i] * in.lambda[i];
  };
  const auto dot = [&](const Both& a, const Both& b) {
    return a.d.dot(weight_.cwiseProduct(b.d)) + a.lambda.dot(system.weight.cwiseProduct(b.lambda));
  };

  Convergence state;
  Both x{d, lambda}, r{Vector::Zero(A_.rows()), Vector(system.size())}, image{Vector(A_.rows()), Vector()};
  for (std::ptrdiff_t i = 0; i < system.size(); ++i) r.lambda[i] = system[i].value;
  const double size = std::sqrt(dot(r, r));
  if (size == 0.0) {
    d.setZero();
    lambda.setZero();
    state.converged = true;
    return state;
  }
  if (!d.isZero(0) || !lambda.isZero(0)) {
    apply(x, image);
    ++state.iterations;
    r.add(-1.0, image);
  }
  struct Direction {
    Both z, image;  // image = K z, of norm 1
  };
  std::vector<Direction> kept;
  bool rounded = true;
  int stalled = 0;  // directions in a row that did not halve the residual
  for (;;) {
    state.residual = std::sqrt(dot(r, r)) / size;
    if (!std::isfinite(state.residual))
      throw SolveFailed("the saddle point's residual is " + number_text(state.residual) +
                        ". Are all positions and forces finite?");
    state.converged = state.residual <= options_.tolerance;
    if (state.converged || state.iterations >= options_.max_iterations) break;
    Direction next;
    next.image.d.resize(A_.rows());
    state.iterations +=
        correct(system, r, next.z, std::max(finest, 0.5 * options_.tolerance / state.residual), rounded);
    apply(next.z, next.image);
    ++state.iterations;
    for (const Direction& before : kept) {
      const double along = dot(next.image, before.image);
      next.image.add(-along, before.image);
      next.z.add(-along, before.z);
    }
    const double length = std::sqrt(dot(next.image, next.image));
    if (!(length > 0.0)) break;
    next.image.d /= length, next.image.lambda /= length;
    next.z.d /= length, next.z.lambda /= length;
    const double along = dot(r, next.image);
    x.add(along, next.z);
    r.add(-along, next.image);
    const double reached = std::sqrt(dot(r, r)) / size;
    // Rows that nearly repeat others in N but not in G make a direction that takes up little.
    stalled = reached <= std::max(0.5 * state.residual, options_.tolerance) ? 0 : stalled + 1;
    if (stalled == patience) {
      if (!rounded) break;
      rounded = false;
      stalled = 0;
    }
    if (kept.size() == directions) kept.erase(kept.begin());
    kept.push_back(std::move(next));
  }
  state.converged = state.residual <= options_.tolerance;
  d = std::move(x.d);
  lambda = std::move(x.lambda);
  return state;
}

}  // namespace plica
