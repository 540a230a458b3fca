#pragma once
#include <limits>
#include <map>
#include <optional>

#include "plica/contact/enforcement.hpp"
#include "plica/contact/normal_stress.hpp"
#include "plica/contact/pairs.hpp"
#include "plica/contact/path.hpp"

namespace plica {

/// The contact forces of one configuration, and how they were found.
struct Contacts {
  std::vector<Constraint> constraints;
  /// As last solved for: the constraints' normals, then, with friction, two tangents for each.
  std::vector<Row> rows;
  Vector force;            // (rows) N, >= 0 on normals; the multiplier of Paper A is its negative
  int passes = 0;          // linearisations of the constraints
  int pivots = 0;          // active sets (with friction: sweeps) tried, over all passes
  int augmentations = 0;   // of Uzawa's iteration
  double gap_error = 0.0;  // m, largest left
  bool converged = true;   // false where augmentations ran out with a gap error above the tolerance
  bool any_force() const { return force.size() > 0 && force.maxCoeff() > 0; }
  /// Adds the forces on all nodes to `nodal` (3 n).
  void add_forces(Vector& nodal) const;
  /// Place of a key among the constraints, or -1.
  std::ptrdiff_t place_of(std::int32_t key) const;
  /// N, zero where there is no constraint of this key.
  double force_of(std::int32_t key) const;
  /// What carries force, keys ascending, and its forces (N).
  std::pair<std::vector<std::int32_t>, Vector> closed() const;
};

/// Detects contact and finds the forces that end it: constraints are linearised at the current positions, solved
/// for, and rebuilt at the positions that follow, until no gap and no closed one is off by more than the
/// tolerance. Slaves are the nodes of the finer side (mortar faces: means around its corners); with multipliers,
/// also those nodes of the other side (mortar faces: of both) that are still inside by more than the tolerance
/// once the first ones are out. So matched meshes give one row a node pair, and a coarse side is not run through.
/// Constraints found in a step stay candidates until its end.
/// With augmented multipliers each pass is an augmentation.
/// Throws SolveFailed, naming the worst constraint and its place, when max_passes do not suffice.
class Collision {
 public:
  struct Options {
    double tolerance = 1e-5;  // -, > 0: largest gap error, in mean interface edges
    int max_passes = 200;     // >= 1; most steps take 1 to 3, two folds edge to edge can take a hundred
    void validate() const;
  };

  /// Throws InvalidInput for a parameter outside its range, for friction with a penalty, for faces that are not
  /// the airway's, and for mortar faces with the volume penalty or Nitsche's method.
  Collision(Airway airway, const Points& reference, Enforcement enforcement, std::optional<Friction> friction,
            Options options, std::unique_ptr<ContactPath> path, const FaceMethod& faces = AtNodes{});
  Collision(const Collision&) = delete;
  Collision& operator=(const Collision&) = delete;

  const Detector& detector() const { return detector_; }
  Detector& detector() { return detector_; }
  /// Seconds spent on finding constraints, since construction.
  double detection_time() const { return detection_time_; }

  /// Renews the airway at x (n, 3), where a step begins and the surfaces are `depth` (m) deep in each other.
  void renew(const Points& x, double depth);
  /// Forgets where earlier steps ended, so that the next one depends on the state alone.
  void forget() { path_->forget(); }
  /// Adds to a (3 n) what is known of the accelerations that the forces last found cause: a start for their solve.
  void add_response(const Contacts& contacts, Vector& a) const {
    path_->add_response(contacts.rows, contacts.force, a);
  }

  /// What is known from the step before.
  struct Before {
    const Points& x;                          // (n, 3) m
    const std::vector<std::int32_t>& closed;  // keys of the constraints that carried force, ascending
    const Vector& force;                      // (closed) N
    double depth;                             // m, >= 0: deepest penetration
    const NormalStress* stress = nullptr;     // of this step, for Nitsche's method
  };
  /// x_free (n, 3): positions without contact forces; on return x holds them with. scale: see ContactPath.
  Contacts solve(const Points& x_free, double scale, const Before& before, Points& x);
  /// Whether there can be a constraint of this key.
  bool knows(std::int32_t key) const { return kind_->knows(key); }
  /// Takes up positions x, for the detector and the two that follow.
  void update(const Points& x);
  /// (n) Pa at x, the positions of the last update, on both surfaces, zero elsewhere: at nodes |nodal force|
  /// (with friction, its part along the surface's normal) over tributary area; of mortar faces a constraint's
  /// force over its area at slave corners, linear on their faces, interpolated on the other side.
  Vector pressure(const Contact& contact, const Points& x);
  /// What is pressed on a side, by nodes; of mortar faces that of the slave side.
  std::vector<PressedNode> pressed(const ContactSurface& side, const Contact& contact, const Points& x);

 private:
  /// Where Uzawa's iteration of a step stands.
  struct Uzawa {
    double stiffness = 0.0;                                       // N/m
    std::map<std::int32_t, double> multiplier;                    // N, by key
    double last_error = std::numeric_limits<double>::infinity();  // m
  };

  /// What a call of solve() is about, and how far it has come.
  struct Search {
    const Points& x_free;
    double scale;
    const Before& before;
    double reach;                      // m
    std::vector<std::int32_t> keys{};  // candidates of this step, ascending
    Uzawa uzawa{};
    Contacts last{};  // of the last pass
  };

  Search begin(const Points& x_free, double scale, const Before& before) const;
  std::vector<Constraint> constraints_at(const Search& search, const Points& x);
  /// Adds what is violated by more than `least` (m) to the candidates, see ConstraintKind; whether any was new.
  bool add_candidates(Search& search, const Points& x, const ContactSurface& side, double least);
  /// Whether nothing is left to do for these constraints. With augmented multipliers the forces become the next
  /// multipliers, and the stiffness is raised where that did too little.
  bool settled(Search& search, const std::vector<Constraint>& constraints, const Points& x) const;
  bool augmented_enough(Search& search, const std::vector<Constraint>& constraints, const Points& x) const;
  /// Forces that close the constraints as linearised at x. By the gaps' own gradients first, which converges in
  /// few passes; these and the normals make an unsymmetric problem that need not have a solution, so where none is
  /// found, by the normals, exact in the gaps at x and symmetric. Leaves the rows in search.last.rows.
  Complementarity closing_forces(Search& search, const std::vector<Constraint>& constraints, const Points& x);
  /// The nodal forces (3 n) without what friction adds along the surfaces.
  Vector without_shear(const Vector& force) const;
  double tolerance() const { return options_.tolerance * detector_.mean_edge(); }  // m

  Detector detector_;
  double detection_time_ = 0.0;
  Enforcement enforcement_;
  std::optional<Friction> friction_;
  Options options_;
  std::unique_ptr<ConstraintKind> kind_;
  std::unique_ptr<ContactPath> path_;
};

}  // namespace plica
