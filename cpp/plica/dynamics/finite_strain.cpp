#include "plica/dynamics/finite_strain.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "plica/core/error.hpp"
#include "plica/tissue/element.hpp"

namespace plica {

namespace {

constexpr double rounded = 64 * std::numeric_limits<double>::epsilon();

/// m, a strain of some 1e-7 of the smallest cell: a difference of forces has half its digits then.
double hardly_a_strain(const TetMesh& mesh) {
  double smallest = std::numeric_limits<double>::infinity();
  Element element(mesh.order());
  for (std::ptrdiff_t c = 0; c < mesh.cell_count(); ++c) {
    element.place(mesh.points, mesh.cells.row(c).data());
    smallest = std::min(smallest, element.volume());
  }
  return 1e-7 * std::cbrt(smallest);
}

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
      tissue_(tissue),
      stiffness_(stiffness),
      viscosity_(viscosity),
      supports_(supports),
      copies_(copies),
      force_(mesh, tissue),
      held_(held_at_origin(mesh, force_, copies)),
      little_(hardly_a_strain(mesh)) {}

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

ExcessForce::Force ExcessForce::at_start(const Vector& u, const Vector& v) const {
  Force force;
  if (const auto cell = at(u, v, force))
    throw InvalidInput("Scene: displacement at t = 0: " + cell_text(*cell) +
                       " is inside out; must keep its orientation. Reduce the initial displacement.");
  return force;
}

Vector ExcessForce::elastic(const Vector& u) const {
  InternalForce::Force own;
  if (const auto cell = force_.at(u, Vector::Zero(u.size()), own)) fail_inside_out(*cell, "");
  return copies_ * own.elastic;
}

Vector ExcessForce::slopes(const Vector& u, const Vector& held, const Vector& x, double elastic,
                           double viscous) const {
  const double largest = x.cwiseAbs().maxCoeff();
  if (!(largest > 0)) return Vector::Zero(x.size());
  const double share = little_ / largest;
  InternalForce::Force own;
  if (const auto cell = force_.at(u + share * x, viscous * x, own)) fail_inside_out(*cell, "");
  Vector image = (elastic / share) * (copies_ * own.elastic - held);
  if (force_.viscous()) image += copies_ * own.viscous;  // linear in v
  return image;
}

void ExcessForce::fail_inside_out(std::int32_t cell, const std::string& how) const {
  throw SolveFailed(
      "tissue at finite strain: " + cell_text(cell) + " turns inside out" + how +
      "; must keep its orientation. Take a shorter time.step, less pressure, or stiffer tissue there.");
}

std::string ExcessForce::cell_text(std::int32_t cell) const {
  return "cell " + std::to_string(cell) + " at " +
         place_text(mesh_.points(mesh_.cells.row(cell), Eigen::all).colwise().mean());
}

std::string ExcessForce::node_text(std::ptrdiff_t unknown) const {
  return "at " + place_text(mesh_.points.row(unknown / 3));
}

}  // namespace plica
