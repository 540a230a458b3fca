#pragma once
#include "plica/contact/enforcement.hpp"
#include "plica/contact/pairs.hpp"
#include "plica/contact/path.hpp"

namespace plica {

/// The contact forces of one configuration, and how they were found.
struct Contacts {
  std::vector<Pair> pairs;
  std::vector<Row> rows;  // (pairs) as last solved for
  Vector force;           // (pairs) N, >= 0; the multiplier of Paper A is its negative
  int passes = 0;         // linearisations of the pairs
  int pivots = 0;         // active sets tried, over all passes
  bool any_force() const { return force.size() > 0 && force.maxCoeff() > 0; }
  /// Adds the forces on all nodes to `nodal` (3 n).
  void add_forces(Vector& nodal) const;
};

/// Detects contact and finds the forces that end it: pairs are linearised at the current positions, solved
/// for, and rebuilt at the positions that follow, until no gap and no closed pair is off by more than the
/// tolerance. Slaves are the nodes of the finer side; with multipliers, also those nodes of the other side that
/// are still inside by more than the tolerance once the first ones are out. So matched meshes give one row a
/// node pair, and a coarse side is not run through. Pairs found in a step stay candidates until its end.
/// Throws SolveFailed, naming the worst pair and its place, when max_passes do not suffice.
class Collision {
 public:
  struct Options {
    double tolerance = 1e-5;  // -, > 0: largest gap error, in mean interface edges
    int max_passes = 200;     // >= 1; most steps take 1 to 3, two folds edge to edge can take a hundred
    void validate() const;
  };

  Collision(Airway airway, const Points& reference, Enforcement enforcement, Options options,
            std::unique_ptr<ContactPath> path);

  const Detector& detector() const { return detector_; }
  Detector& detector() { return detector_; }
  /// Seconds that solve() has spent on finding pairs, since construction.
  double detection_time() const { return detection_time_; }

  /// Forgets where earlier steps ended, so that the next one depends on the state alone.
  void forget() { path_->forget(); }
  /// Adds to a (3 n) what is known of the accelerations that the forces last found cause: a start for their solve.
  void add_response(const Contacts& contacts, Vector& a) const {
    path_->add_response(contacts.rows, contacts.force, a);
  }

  /// What is known from the step before.
  struct Before {
    const Points& x;                          // (n, 3) m
    const std::vector<std::int32_t>& closed;  // keys of the pairs that carried force, ascending
    double depth;                             // m, >= 0: deepest penetration
  };
  /// x_free (n, 3): positions without contact forces; on return x holds them with. scale: see ContactPath.
  Contacts solve(const Points& x_free, double scale, const Before& before, Points& x);

 private:
  void update_detector(const Points& x);
  std::vector<Pair> pairs_at(const Points& x, const std::vector<std::int32_t>& keys);
  /// Adds the slaves on `side` (volume penalty: the tetrahedra) deeper than `least`; whether any was new.
  bool add_candidates(const Points& x, double reach, const ContactSurface& side, double least,
                      std::vector<std::int32_t>& keys);
  /// Forces that close the pairs as linearised at x. By the gaps' own gradients first, which converges in few
  /// passes; these and the normals make an unsymmetric problem that need not have a solution, so where none is
  /// found, by the normals, exact in the gaps at x and symmetric.
  Complementarity closing_forces(const std::vector<Pair>& pairs, const Points& x, const Points& x_free,
                                 double scale, std::vector<char> guess, std::vector<Row>& rows);
  double tolerance() const { return options_.tolerance * detector_.mean_edge(); }  // m

  Detector detector_;
  double detection_time_ = 0.0;
  Enforcement enforcement_;
  Options options_;
  std::unique_ptr<ContactPath> path_;
};

}  // namespace plica
