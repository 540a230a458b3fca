#include "plica/dynamics/finite_strain.hpp"

#include <cmath>
#include <limits>

#include "plica/core/error.hpp"

namespace plica {

namespace {

constexpr double rounded = 64 * std::numeric_limits<double>::epsilon();

/// What holds the tissue at the origin, at supports, as large as the stresses that cancel inside.
double held_at_origin(const TetMesh& mesh, const InternalForce& law, int copies) {
  if (!mesh.stretched()) return 0.0;
  const Vector none = Vector::Zero(3 * mesh.node_count());
  InternalForce::Force held;
  return law.at(none, none, held) ? 0.0 : copies * held.elastic.norm();
}

}  // namespace

void FiniteStrain::validate() const {
  if (!(tolerance > 0) || !std::isfinite(tolerance))
    throw InvalidInput("FiniteStrain", "tolerance", tolerance, "of the tissue's force", "> 0 and finite");
  if (max_iterations < 1) throw InvalidInput("FiniteStrain", "max_iterations", max_iterations, "", ">= 1");
}

ExcessForce::ExcessForce(const FiniteStrain& options, const TetMesh& mesh, const Tissue& tissue,
                         const BlockMatrix& stiffness, const std::optional<BlockMatrix>& viscosity,
                         const Supports& supports, int copies)
    : options_(options),
      mesh_(mesh),
      stiffness_(stiffness),
      viscosity_(viscosity),
      supports_(supports),
      copies_(copies),
      force_(mesh, tissue),
      held_(held_at_origin(mesh, force_, copies)) {}

std::optional<std::int32_t> ExcessForce::at(const Vector& u, const Vector& v, Force& force) const {
  InternalForce::Force own;
  if (const auto cell = force_.at(u, v, own)) return cell;
  force.elastic = copies_ * own.elastic;
  Vector whole = force.elastic;
  const Vector linear = stiffness_ * u;
  force.elastic -= linear;
  force.round_off = rounded * (linear.norm() + held_);
  force.viscous.resize(0);
  if (force_.viscous()) {
    force.viscous = copies_ * own.viscous;
    whole += force.viscous;
    force.viscous -= *viscosity_ * v;
  }
  supports_.project(whole);
  force.whole = whole.norm();
  return std::nullopt;
}

std::string ExcessForce::cell_text(std::int32_t cell) const {
  return "cell " + std::to_string(cell) + " at " +
         place_text(mesh_.points(mesh_.cells.row(cell), Eigen::all).colwise().mean());
}

std::string ExcessForce::node_text(std::ptrdiff_t unknown) const {
  return "at " + place_text(mesh_.points.row(unknown / 3));
}

}  // namespace plica
