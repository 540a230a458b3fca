#include "plica/dynamics/posture.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "plica/core/error.hpp"
#include "plica/core/require.hpp"
#include "plica/dynamics/rigid_motion.hpp"
#include "plica/solve/linear_solver.hpp"

namespace plica {

namespace {

constexpr double least_part = 1.0 / 512;
constexpr int most_iterations = 12;
constexpr double solve_tolerance = 1e-9;
constexpr double least_step = 1e-11;  // of the mesh's size: the error after it is the square of that

std::string percent_text(double share) { return number_text(std::floor(1000 * share) / 10); }

struct NotSolved : SolveFailed {
  using SolveFailed::SolveFailed;
};

/// The way from rest to a posture, and where on it the tissue is.
class Way {
 public:
  Way(const TetMesh& mesh, const Tissue& tissue, const Supports& supports, const HeldAt& held)
      : mesh_(mesh),
        assembler_(mesh),
        tissue_(tissue),
        supports_(supports),
        held_(held),
        size_((mesh.points.colwise().maxCoeff() - mesh.points.colwise().minCoeff()).maxCoeff()) {
    found_.displacement = Points::Zero(mesh.node_count(), 3);
    for (const Material& material : tissue.materials) active_.push_back(material.active_stress);
  }

  Posture walk() {
    double done = 0.0, part = 1.0;
    std::string why;
    while (done < 1) {
      const double aim = std::min(done + part, 1.0);
      if (go_on(done, aim, why)) {
        done = aim;
        ++found_.parts;
        part *= 1.5;
      } else if ((part *= 0.5) < least_part) {
        throw SolveFailed("Posture: no equilibrium beyond " + percent_text(done) + " % of it: " + why +
                          ". Take less of it, or tissue that is stiffer against it.");
      }
    }
    return found_;
  }

 private:
  Assembler::Stretched at(const Vector& u) const {
    return assembler_.stretched(tissue_, mesh_.points + as_points(u));
  }
  Vector solved(BlockMatrix slope, Vector force) const {
    supports_.project(force);
    supports_.constrain(slope);
    Guess step;
    const auto solver = LinearSolver::make(slope, {solve_tolerance, LinearSolver::Cholesky{}});
    if (!solver->solve(force, step).converged) throw NotSolved("a linear system is not solved");
    return step.x;
  }

  /// By how much what is held moves between two places on the way.
  Vector moved(double from, double to) const {
    const Points there = held_(to), here = held_(from);
    if (there.rows() != mesh_.node_count() || here.rows() != there.rows())
      throw InvalidInput("Posture", "rows of what is held", static_cast<double>(there.rows()), "",
                         std::to_string(mesh_.node_count()) + ", one a node");
    Vector all = as_vector(Points(there - here));
    if (!all.allFinite()) throw InvalidInput("Posture: where nodes are held is not finite; must be finite.");
    Vector free = all;
    supports_.project(free);
    return all - free;
  }

  /// One part of the way, from an equilibrium to the next; else why there is none so near.
  bool go_on(double done, double aim, std::string& why) {
    set_active(aim);
    why = "Newton's method does not lead on";
    Vector u = as_vector(found_.displacement);
    try {
      const Vector given = moved(done, aim);
      Assembler::Stretched now = at(u);
      u += given + solved(now.slope, -(now.force + now.slope * given));
      for (int i = 0; i < most_iterations; ++i) {
        now = at(u);
        if (!now.force.allFinite()) break;
        ++found_.iterations;
        const Vector step = solved(std::move(now.slope), -now.force);
        u += step;
        if (step.cwiseAbs().maxCoeff() > least_step * size_) continue;
        if (const auto cell = first_folded_cell(mesh_.points + as_points(u), mesh_.cells)) {
          why = "cell " + std::to_string(*cell) + " at " + centre_text(*cell) + " folds over";
          break;
        }
        found_.displacement = as_points(u);
        return true;
      }
    } catch (const CellInverted& failure) {
      why = failure.what();
    } catch (const NotSolved& failure) {
      why = failure.what();
    } catch (const SolveFailed&) {
      why = "the tissue buckles";
    }
    set_active(done);
    return false;
  }

  std::string centre_text(std::ptrdiff_t cell) const {
    return place_text(mesh_.points(mesh_.cells.row(cell), Eigen::all).colwise().mean());
  }

  void set_active(double share) {
    for (std::size_t i = 0; i < active_.size(); ++i) tissue_.materials[i].active_stress = share * active_[i];
  }

  const TetMesh& mesh_;
  const Assembler assembler_;
  Tissue tissue_;
  const Supports& supports_;
  const HeldAt& held_;
  const double size_;  // m
  std::vector<double> active_;
  Posture found_;
};

}  // namespace

Posture stretched(const TetMesh& mesh, const Tissue& tissue, const Supports& supports, const HeldAt& held) {
  check_mesh(mesh);
  if (mesh.stretched()) throw InvalidInput("Posture: the mesh is stretched already; must be at rest.");
  tissue.validate(mesh);
  require_size("Posture", "supports", supports.size(), 3 * mesh.node_count());
  if (!rigid_motions(mesh, supports).empty())
    throw InvalidInput("Posture: the supports let tissue move without strain; must be held for a posture.");
  return Way(mesh, tissue, supports, held).walk();
}

}  // namespace plica
