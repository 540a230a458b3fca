#include "plica/dynamics/start.hpp"

#include <memory>

#include "plica/core/error.hpp"

namespace plica {

namespace {

Vector solved(const ConjugateGradient& solver, const Vector& rhs, const KrylovOptions& options) {
  Vector x = Vector::Zero(rhs.size());
  const Convergence end = solver.solve(rhs, x);
  if (!end.converged)
    throw SolveFailed("Simulation: the initial acceleration did not converge (residual " +
                      number_text(end.residual) + " after " + std::to_string(end.iterations) + " iterations). " +
                      (end.iterations < options.max_iterations
                           ? "Rounding allows no less: loosen solver.tolerance, or take a shorter step."
                           : "Raise max_iterations of solver.method.conjugate_gradients."));
  return x;
}

/// p and d of S p = r, S d = (S - M) p: p + d is M^-1 r but for the second order in S - M, and bounded.
struct Resolved {
  Vector p, d;
};
Resolved resolve(const StartSystem::Solve& solve, const StartSystem& system, const Vector& r) {
  Vector p = solve(r);
  Vector d = p - solve(system.inertia(p));
  return {std::move(p), std::move(d)};
}

}  // namespace

BlockMatrix combine_matrices(double m, const NodalMatrix& M, double c, const std::optional<BlockMatrix>& C,
                             double k, const BlockMatrix& K, const Supports& supports) {
  BlockMatrix A(K.pattern());
  for (std::size_t i = 0; i < A.values().size(); ++i) A.values()[i] = k * K.values()[i];
  if (C)
    for (std::size_t i = 0; i < A.values().size(); ++i) A.values()[i] += c * C->values()[i];
  for (std::size_t e = 0; e < M.values().size(); ++e)
    for (int d = 0; d < 3; ++d) A.values()[9 * e + 4 * d] += m * M.values()[e];
  supports.constrain(A);
  return A;
}

Start start_motion(const SchemeCoefficients& scheme, double step, const StartMatrices& matrices,
                   const StartForces& forces, const KrylovOptions& options) {
  const StartSystem system{[&](double c, double k) {
                             const auto matrix = std::make_shared<const BlockMatrix>(
                                 combine_matrices(1, matrices.M, c, matrices.C, k, matrices.K, matrices.supports));
                             const auto solver = std::make_shared<const ConjugateGradient>(*matrix, options);
                             return StartSystem::Solve([matrix, solver, options](const Vector& force) {
                               return solved(*solver, force, options);
                             });
                           },
                           [&](const Vector& a) {
                             Vector inertia = matrices.M * a;
                             matrices.supports.project(inertia);
                             return inertia;
                           }};
  return start_motion(scheme, step, system, forces);
}

Start start_motion(const SchemeCoefficients& scheme, double step, const StartSystem& system,
                   const StartForces& forces) {
  const Vector& load = forces.elastic_and_load;
  const Vector nothing = Vector::Zero(load.size());
  const double excess = scheme.beta - 0.5 * scheme.gamma;
  if (!(excess > 0)) return {system.solver(0, 0)(load + forces.viscous), nothing, nothing, nothing};
  const double c = (1 + scheme.alpha) * scheme.gamma * step, k = (1 + scheme.alpha) * scheme.beta * step * step;
  Start start{nothing, nothing, nothing, nothing};
  const auto add = [&](const Resolved& part, double stiff_share) {
    start.acceleration += part.p + part.d;
    start.displacement += stiff_share * k * part.d;
    start.velocity += c * part.d;
    start.shift += (0.5 * c * step + 2 * excess * step * step) * part.d;
  };
  if (!load.isZero(0)) add(resolve(system.solver(c, k), system, load), 1);
  if (!forces.viscous.isZero(0)) add(resolve(system.solver(c, 0), system, forces.viscous), 0);
  return start;
}

}  // namespace plica
