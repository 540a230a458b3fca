#pragma once
#include <optional>

#include "plica/dynamics/scene.hpp"
#include "plica/dynamics/scheme.hpp"
#include "plica/dynamics/start.hpp"
#include "plica/dynamics/symmetric_part.hpp"
#include "plica/solve/linear_solver.hpp"

namespace plica {

struct State;

/// The equation of motion of a scene in steps of h, M a + C V + K U = f, positions counted from an origin near the
/// mesh: far from 0, sums of coordinates and displacements would lose digits that gaps need. Of a symmetric scene
/// it is that of its part, u = S q, with the matrices S^T M S and so on: vectors and matrices have the part's
/// unknowns, energies are those of the whole; positions are of all nodes.
class Motion {
 public:
  struct Options {
    TimeScheme scheme = HilberHughesTaylor{};
    double step = 50e-6;           // s, > 0
    LinearSolver::Options solver;  // of the step's linear systems
    CellMass mass = CellMass::consistent;
    void validate() const;
  };

  /// Assembles the matrices. `part`: of a symmetric scene, else null; the assembler is its. All must outlive it.
  /// Throws InvalidInput.
  Motion(const Scene& scene, const SymmetricPart* part, const Assembler& assembler, const Options& options);
  Motion(const Motion&) = delete;
  Motion& operator=(const Motion&) = delete;

  const Options& options() const { return options_; }
  const SchemeCoefficients& scheme() const { return scheme_; }
  double step() const { return options_.step; }
  /// Whether steps solve for nothing: then there is no step matrix.
  bool is_explicit() const { return std::holds_alternative<CentralDifferences>(options_.scheme); }
  const Supports& supports() const { return part_ ? part_->supports : scene_.supports; }
  /// Null where all nodes move on their own.
  const MirrorImages* images() const { return part_ ? &part_->images : nullptr; }
  const NodalMatrix& mass() const { return mass_; }
  const BlockMatrix& stiffness() const { return stiffness_; }
  /// Absent where no material is viscous.
  const std::optional<BlockMatrix>& viscosity() const { return viscosity_; }
  /// A = M + (1+alpha) gamma h C + (1+alpha) beta h^2 K.
  /// Throws InvalidInput with CentralDifferences, which have none.
  const BlockMatrix& step_matrix() const;
  /// Of the step matrix, where there is one.
  /// Whether steps have linear systems of all unknowns: not explicit and reduced ones.
  bool solves() const { return solver_ != nullptr; }
  /// Where it solves.
  const LinearSolver& solver() const { return *solver_; }
  /// Null where tissue is linear.
  const ExcessForce* excess() const { return excess_ ? &*excess_ : nullptr; }
  /// Nodes, ascending; none unless the scene's contact asks for it.
  const std::vector<std::int32_t>& massless() const { return massless_; }
  /// Of the first step; empty before begin().
  const Start& start() const { return start_; }

  const Vector3& origin() const { return origin_; }       // m, zero but for meshes far from it
  const Points& reference() const { return reference_; }  // (n, 3) m, from the origin
  /// (n, 3) m from the origin, of all nodes.
  Points positions(const Vector& displacement) const {
    if (!part_) return reference_ + as_points(displacement);
    return reference_ + as_points(part_->images.spread(displacement));
  }
  /// At all nodes (3 n): S q.
  Vector everywhere(const Vector& q) const { return part_ ? part_->images.spread(q) : q; }
  /// At one of all nodes.
  Vector3 at(std::int32_t node, const Vector& q) const {
    return part_ ? part_->images.at(node, q) : q.segment<3>(3 * static_cast<std::ptrdiff_t>(node));
  }
  /// S^T of forces on all nodes, and the symmetric forces on all nodes of which that comes.
  Vector folded(Vector force) const { return part_ ? part_->images.folded(force) : std::move(force); }
  Vector shared(Vector force) const { return part_ ? part_->images.shared(force) : std::move(force); }
  /// From the origin to the scene's own coordinates.
  Points in_scene(const Points& x) const { return x.rowwise() + origin_.transpose(); }

  /// Completes a state of t = 0, whose displacement, velocity and load are given, by what the first step needs.
  /// Throws SolveFailed.
  void begin(State& state);
  /// What the matrices make of an acceleration, (3 n): M a, C a (empty where no material is viscous), K a.
  struct Products {
    Vector inertial, viscous, elastic;
  };
  Products products(const Vector& a) const;
  /// A a of these.
  Vector image(const Products& products) const;

  /// A a = force, from guess, to |force - A a| <= tolerance |force|; held unknowns of a force are zero. Returns
  /// the iterations. Throws SolveFailed.
  int solve(const Vector& force, Guess& guess, double tolerance) const;
  /// The same to the solver's own tolerance, with the products of what is found.
  int solve(const Vector& force, Guess& guess, Products& products) const;

 private:
  /// The iterations of a solve. Throws SolveFailed where it has not converged.
  int checked(const Convergence& end, double tolerance) const;

  const Scene& scene_;
  const SymmetricPart* part_;
  Options options_;
  SchemeCoefficients scheme_;
  Vector3 origin_;
  Points reference_;
  std::vector<std::int32_t> massless_;
  NodalMatrix mass_;
  BlockMatrix stiffness_;
  std::optional<BlockMatrix> viscosity_;
  std::optional<ExcessForce> excess_;
  std::optional<BlockMatrix> step_matrix_;
  std::unique_ptr<const LinearSolver> solver_;
  Start start_;
};

}  // namespace plica
