#include "plica/dynamics/static_way.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "plica/core/error.hpp"
#include "plica/solve/linear_solver.hpp"

namespace plica {

namespace {

constexpr double least_part = 1.0 / 512;
constexpr int most_iterations = 12;
constexpr double solve_tolerance = 1e-9;
constexpr double least_step = 1e-11;  // of the mesh's size: the error after it is the square of that
constexpr double near = 0.25;         // of a part's motion, by which the trapezoidal rule may miss it

std::string percent_text(double share) { return number_text(std::floor(1000 * share) / 10); }

struct NotSolved : SolveFailed {
  using SolveFailed::SolveFailed;
};

class Walk {
 public:
  Walk(const TetMesh& mesh, const Supports& supports, const StaticWay& way)
      : mesh_(mesh),
        supports_(supports),
        way_(way),
        size_((mesh.points.colwise().maxCoeff() - mesh.points.colwise().minCoeff()).maxCoeff()) {
    found_.displacement = Vector::Zero(3 * mesh.node_count());
  }

  StaticEnd go() {
    double done = 0.0, part = 1.0;
    std::string why;
    while (done < 1) {
      const double aim = std::min(done + part, 1.0);
      if (go_on(done, aim, why)) {
        done = aim;
        ++found_.parts;
        part *= 1.5;
      } else if ((part *= 0.5) < least_part) {
        throw SolveFailed(way_.name + ": no equilibrium beyond " + percent_text(done) + " % of " + way_.of + ": " +
                          why + ". " + way_.hint);
      }
    }
    return found_;
  }

 private:
  Vector solved(BlockMatrix slope, Vector force) const {
    supports_.project(force);
    supports_.constrain(slope);
    Guess step;
    const auto solver = LinearSolver::make(slope, {solve_tolerance, LinearSolver::Cholesky{}});
    if (!solver->solve(force, step).converged) throw NotSolved("a linear system is not solved");
    return step.x;
  }

  /// How the equilibrium u at a share moves on to another share, to first order.
  Vector foretell(const Vector& u, double from, double to) const {
    const Vector given = way_.moved(from, to);
    Assembler::Stretched there = way_.balance(u, to);
    const Vector force = -(there.force + there.slope * given);
    return given + solved(std::move(there.slope), force);
  }

  /// One part of the way, from an equilibrium to the next; else why there is none so near. It must be what the
  /// slopes at both ends foretell: Newton's method may as well end in an equilibrium that no way leads to.
  bool go_on(double done, double aim, std::string& why) {
    why = "Newton's method does not lead on";
    Vector u = found_.displacement;
    try {
      const Vector foretold = foretell(u, done, aim);
      u += foretold;
      for (int i = 0; i < most_iterations; ++i) {
        Assembler::Stretched now = way_.balance(u, aim);
        if (!now.force.allFinite()) break;
        ++found_.iterations;
        const Vector step = solved(std::move(now.slope), -now.force);
        u += step;
        if (step.cwiseAbs().maxCoeff() > least_step * size_) continue;
        if (const auto cell = first_folded_cell(mesh_.points + as_points(u), mesh_.cells)) {
          why = "cell " + std::to_string(*cell) + " at " + centre_text(*cell) + " folds over";
          break;
        }
        const Vector whole = u - found_.displacement;
        const bool rounded = whole.cwiseAbs().maxCoeff() < least_step * size_ / near;
        if (!rounded && (0.5 * (foretold - foretell(u, aim, done)) - whole).norm() > near * whole.norm()) {
          why = "it gives way to a shape that is far off";
          break;
        }
        found_.displacement = u;
        return true;
      }
    } catch (const CellInverted& failure) {
      why = failure.what();
    } catch (const NotSolved& failure) {
      why = failure.what();
    } catch (const SolveFailed&) {
      why = "the tissue buckles";
    }
    return false;
  }

  std::string centre_text(std::ptrdiff_t cell) const {
    return place_text(mesh_.points(mesh_.cells.row(cell), Eigen::all).colwise().mean());
  }

  const TetMesh& mesh_;
  const Supports& supports_;
  const StaticWay& way_;
  const double size_;  // m
  StaticEnd found_;
};

}  // namespace

StaticEnd walk(const TetMesh& mesh, const Supports& supports, const StaticWay& way) {
  return Walk(mesh, supports, way).go();
}

}  // namespace plica
