#pragma once
#include <optional>

#include "plica/contact/contacts.hpp"
#include "plica/contact/facing_nodes.hpp"
#include "plica/contact/force_solver.hpp"
#include "plica/contact/method.hpp"
#include "plica/contact/pairs.hpp"

namespace plica {

/// Detects contact and finds the forces that end it: constraints are linearised at the current positions, solved
/// for, and rebuilt at the positions that follow, until no gap and no closed one is off by more than the
/// tolerance. Slaves are the nodes of the finer side (mortar faces: averages around its corners); with
/// multipliers, also those nodes of the other side (mortar faces: of both) that are still inside by more than the
/// tolerance once the first ones are out. So matched meshes give one row a node pair, and a coarse side is not run
/// through. Constraints found in a step stay candidates until its end. With augmented multipliers each pass is an
/// augmentation. Passes that come no closer, max_passes of them, or constraints that cannot all be met end with
/// the pass that came closest: unconverged if its gap error is within ten tolerances, else with SolveFailed, which
/// says why, or with nodes held apart from those they face (hold_facing).
class Collision {
 public:
  struct Options {
    double tolerance = 1e-5;  // -, in (0, 1): largest gap error, in mean interface edges
    int max_passes = 200;     // >= 1; most steps take 1 to 3, two folds edge to edge can take a hundred
    void validate() const;
  };

  /// Throws InvalidInput for a parameter outside its range, for friction or faces that the method cannot have, and
  /// for faces that are not the airway's.
  Collision(Airway airway, const Points& reference, std::unique_ptr<ContactMethod> method,
            std::optional<Friction> friction, Options options, std::unique_ptr<ForceSolver> solver,
            const FaceMethod& faces = AtNodes{});
  Collision(const Collision&) = delete;
  Collision& operator=(const Collision&) = delete;

  const ContactMethod& method() const { return *method_; }
  /// Whether gaps are held at nodes rather than in mortar averages.
  bool at_nodes() const { return at_nodes_; }
  const Detector& detector() const { return detector_; }
  Detector& detector() { return detector_; }
  /// From now on nodes are held apart from those they face at rest (FacingNodes) in a step whose passes fail, as
  /// where tissue folds and nothing tells what faces what. `images`: the surfaces are each other's mirror image at
  /// all times, so that passes also fail where many do not settle, or settle with one surface behind the other.
  /// Nothing where no nodes face each other, with friction, with averages over faces and with methods that are not
  /// exact. Steps then know the positions of all nodes of the surfaces.
  void hold_facing(const Points& reference, bool images);
  /// Nodes that are held so; null where there are none.
  const FacingNodes* facing() const { return facing_ ? &*facing_ : nullptr; }
  /// Seconds spent on finding constraints, since construction.
  double detection_time() const { return detection_time_; }

  /// Renews the airway at x (n, 3), where a step begins and the surfaces are `depth` (m) deep in each other.
  void renew(const Points& x, double depth);
  /// Forgets where earlier steps ended, so that the next one depends on the state alone.
  void forget() { force_solver_->forget(); }
  /// Of nodal forces (3 n) N: see ForceSolver.
  void add_response(const Vector& force, Vector& a) const { force_solver_->add_response(force, a); }

  /// x_free (n, 3): positions without contact forces; on return x holds them with. scale: see ForceSolver.
  /// `known`: what the last call in this step found, for another x_free: the search goes on from there, and begins
  /// anew where that does not settle. Counts of passes and pivots go on. Empty in a step's first call.
  Contacts solve(const Points& x_free, double scale, const BeforeContact& before, Contacts known, Points& x);
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
  /// What a call of solve() is about, and how far it has come.
  struct Search {
    const Points& x_free;
    double scale;
    const BeforeContact& before;
    double reach;                      // m
    double shifted = 0;                // m, of the last pass's move: ForceSolver::shifted
    std::vector<std::int32_t> keys{};  // candidates of this step, ascending
    Contacts last{};                   // of the last pass
    int passes = 0;                    // since it began
  };

  /// How a search ended: with contacts, or with why there are none.
  struct Outcome {
    std::optional<Contacts> contacts;
    std::string failure;
  };
  /// How deep the surfaces can be at x, m (Detector::reach).
  double reach(const BeforeContact& before, const Points& x, double shifted) const {
    return before.moved ? 2 * (*before.moved + shifted) + before.depth
                        : detector_.reach(before.x, x, before.depth);
  }
  /// Passes from where the search stands and x is, at most so many.
  Outcome search_on(Search& search, int max_passes, Points& x);
  /// Whether one surface has passed through the other at x, by more than an unconverged step may leave.
  bool passed_through(const Points& x) const;
  /// The contacts of facing nodes after so many passes and pivots. Throws SolveFailed with the failure of the
  /// search where there are none.
  Contacts held_facing(const Search& search, int passes, int pivots, const std::string& failure, Points& x);
  std::vector<Constraint> constraints_at(const Search& search, const Points& x);
  /// Adds what is violated by more than `least` (m) to the candidates, see ConstraintKind; whether any was new.
  bool add_candidates(Search& search, const Points& x, const ContactSurface& side, double least);
  /// Forces that close the constraints as linearised at x. By the gaps' own gradients first, which converges in
  /// few passes; these and the normals make an unsymmetric problem that need not have a solution, so where none is
  /// found, by the normals, exact in the gaps at x and symmetric; unconverged where these have none either. Leaves
  /// the rows in search.last.rows.
  Complementarity closing_forces(Search& search, const std::vector<Constraint>& constraints, const Points& x);
  /// The nodal forces (3 n) without what friction adds along the surfaces.
  Vector without_shear(const Vector& force) const;
  double tolerance() const { return options_.tolerance * detector_.mean_edge(); }  // m

  Detector detector_;
  double detection_time_ = 0.0;
  std::unique_ptr<ContactMethod> method_;
  std::optional<Friction> friction_;
  Options options_;
  bool at_nodes_;
  std::unique_ptr<ConstraintKind> kind_;
  std::unique_ptr<ForceSolver> force_solver_;
  std::optional<FacingNodes> facing_;
  bool facing_are_images_ = false;
};

}  // namespace plica
