#pragma once
#include <memory>
#include <optional>

#include "plica/contact/contacts.hpp"
#include "plica/contact/enforcement.hpp"
#include "plica/contact/normal_stress.hpp"
#include "plica/contact/pairs.hpp"

namespace plica {

/// What contact knows from the step before.
struct BeforeContact {
  const Points& x;                          // (n, 3) m
  const std::vector<std::int32_t>& closed;  // keys of the constraints that carried force, ascending
  const Vector& force;                      // (closed) N
  double depth;                             // m, >= 0: deepest penetration
  const NormalStress* stress = nullptr;     // of this step, where the method needs it
  /// m, how far any node of the surfaces has moved without contact at most; absent: as positions have it.
  std::optional<double> moved{};
};

/// A way to hold surfaces apart: what it needs of a constraint, when a pass has settled it, which solver it wants
/// and where in the step its gaps are closed. What it remembers is of one step: begin() forgets it.
class ContactMethod {
 public:
  virtual ~ContactMethod() = default;

  // Of a scene
  /// The solver it wants; with friction the condensed one, whose compliance of the rows friction needs.
  ContactSolver solver(bool friction) const { return friction ? ContactSolver(Condensed{}) : own_solver(); }
  /// Whether Coulomb's law can be added to it.
  virtual bool takes_friction() const { return false; }
  /// Where in the step its gaps are closed.
  virtual GapPosition position() const { return EndOfStep{}; }
  /// Whether it sees the tissue's own stress (BeforeContact::stress).
  virtual bool needs_stress() const { return false; }
  /// Whether it closes gaps, so that nodes that the slaves leave inside are held, too.
  virtual bool exact() const { return false; }
  /// What it constrains on these faces; the detector must outlive it. Throws InvalidInput for faces that it cannot
  /// work on.
  virtual std::unique_ptr<ConstraintKind> kind(Detector& detector, const FaceMethod& faces) const;

  // Of a step
  /// Starts one; `before` must live as long as the step. Returns keys of constraints to look at from the start,
  /// ascending.
  virtual std::vector<std::int32_t> begin(const BeforeContact&) { return {}; }
  /// Gives a constraint the stiffness and what else it needs.
  virtual void complete(Constraint&, const Detector&) const {}
  /// Gives a row of a constraint what is neither its gap nor its stiffness.
  virtual void complete(Row&, const Constraint&, const Points& /*x_free*/) const {}
  /// How far a constraint under this force (N, >= 0) is from complementarity at x, m.
  double violation(const Constraint& constraint, double force, const Points& x) const;
  /// Whether a pass that led to x has left nothing to do for these constraints; writes the gap error into `last`.
  virtual bool settled(Contacts& last, const std::vector<Constraint>& constraints, const Points& x,
                       double tolerance);
  /// Whether settled() changes what complete() gives.
  virtual bool renews_constraints() const { return false; }

 private:
  virtual ContactSolver own_solver() const { return Automatic{}; }
  /// Zero where the force p > 0 is the constraint's, m.
  virtual double residual(const Constraint& constraint, double p, const Points& x) const {
    return constraint.residual(p, x);
  }
};

/// Throw InvalidInput for an option outside its range.
std::unique_ptr<ContactMethod> contact_method(const Multipliers& options);
std::unique_ptr<ContactMethod> contact_method(const Penalty& options);
std::unique_ptr<ContactMethod> contact_method(const VolumePenalty& options);
std::unique_ptr<ContactMethod> contact_method(const Augmented& options);
std::unique_ptr<ContactMethod> contact_method(const Nitsche& options);
std::unique_ptr<ContactMethod> contact_method(const Enforcement& enforcement);

/// Throws InvalidInput unless the option is > 0 and finite.
void require_positive(const char* name, double value, const char* unit);

}  // namespace plica
