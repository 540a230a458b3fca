#include "plica/contact/force_solver.hpp"

#include "plica/core/error.hpp"

namespace plica {

Eigen::MatrixXd ForceSolver::compliance(const std::vector<Row>&, double) {
  throw InvalidInput(
      "Contact: friction is solved for over the compliance of the rows; must have the condensed solver.");
}

ContactSolver chosen_solver(const ContactSolver& solver, std::ptrdiff_t surface_nodes) {
  constexpr std::ptrdiff_t most_condensed = 5000;
  if (!std::holds_alternative<Automatic>(solver)) return solver;
  if (surface_nodes <= most_condensed) return Condensed{};
  return Saddle{};
}

const char* name_of(const ContactSolver& solver) {
  struct Name {
    const char* operator()(Automatic) const { return "auto"; }
    const char* operator()(Condensed) const { return "condensed"; }
    const char* operator()(Saddle) const { return "saddle"; }
    const char* operator()(Gmres) const { return "gmres"; }
  };
  return std::visit(Name{}, solver);
}

std::unique_ptr<ForceSolver> force_solver(const ContactSolver& solver, const BlockMatrix& A,
                                          const LinearSolver& linear, const Supports& supports,
                                          const Indices& nodes, const KrylovOptions& options) {
  const ContactSolver chosen = chosen_solver(solver, nodes.size());
  if (std::holds_alternative<Gmres>(chosen)) return gmres_solver(A, supports, nodes, options);
  if (std::holds_alternative<Saddle>(chosen)) return saddle_solver(A, supports, nodes, options);
  return condensed_solver(linear, supports, nodes);
}

}  // namespace plica
