#pragma once
#include <vector>

#include "plica/contact/row.hpp"

namespace plica {

class ContactSurface;

/// A node and its share in a point of a surface.
struct NodeWeight {
  std::int32_t node;
  double weight;
};

/// A point of one surface facing a point of the other, both fixed combinations of nodes: a force p >= 0 along the
/// normal on the first, shared out by the weights, and -p on the second, so both sides sum to zero; and the gap
/// that p holds, their offset along `gradient` and the depth that it may have.
struct Constraint {
  std::int32_t key = -1;             // what it stands for from pass to pass; -1: nothing
  std::int32_t slave = -1;           // node where it is
  std::vector<NodeWeight> weights;   // sum 1 over the slave's side and -1 over the master's
  Vector3 normal = Vector3::Zero();  // unit, from the master's tissue towards the slave's: direction of the force
  Vector3 gradient = Vector3::Zero();  // of the gap, gradient . normal = 1
  double depth = 0.0;                  // m, >= 0: how far behind the master it may be before p holds it
  double area = 0.0;                   // m^2, over which the force is spread; 0: that of its node
  double support = 1.0;                // -, share of its node's area that faces the master, of mortar averages
  double stiffness = 0.0;              // N/m, 0: exact
  double multiplier = 0.0;             // N, >= 0: force at gap 0 where there is a stiffness
  double gamma = 0.0;                  // Pa/m, > 0 where the tissue's own stress counts (Nitsche)

  /// From the master's point to the slave's, m.
  Vector3 offset(const Points& x) const;
  double gap(const Points& x) const { return gradient.dot(offset(x)) + depth; }
  /// Whether the slave lies beside the master rather than over it: further than `least` (m) from its foot, and
  /// more than 60 degrees off the gap's gradient.
  bool beside(const Points& x, double least) const;
  /// Whether it is a mean over so little that it comes and goes with what its nodes do within a pass.
  bool sliver() const { return support < 0.05; }
  /// gap + (p - multiplier) / stiffness: zero where the force p > 0 is the constraint's, m.
  double residual(double p, const Points& x) const;
  /// Takes the other's weights, normal and gradient.
  void keep_direction(const Constraint& other);
  /// Turns the normal halfway to n (unit), unless it would then be further than 60 degrees from the gradient. The
  /// gap stays the same, so gradient . normal may then differ from 1.
  void turn_towards(const Vector3& n);
  /// The row that pushes along the normal and whose gap is direction . offset(x) + constant, `free` at x_free.
  Row row(const Vector3& direction, double free) const;
  /// The row that pushes along t, across the normal, and whose gap is the slip along t since `before`.
  Row slip_row(const Vector3& t, const Points& before, const Points& x_free) const;
};

/// The contact of a step as it is kept.
struct Contact {
  const Vector& nodal_force;                // (3 n) N
  const std::vector<std::int32_t>& closed;  // keys of the constraints that carry force
  const Vector& force;                      // (closed) N
};

/// A node that is pressed, and what it stands for.
struct PressedNode {
  std::int32_t node;
  double area;                        // m^2
  double pressure;                    // Pa
  std::pair<double, double> stretch;  // m, of y
};

/// A kind of contact constraints: which of them are violated, how one looks at given positions, and how they
/// press.
class ConstraintKind {
 public:
  virtual ~ConstraintKind() = default;
  /// Takes up positions x (n, 3), those of the calls that follow.
  virtual void update(const Points& x) = 0;
  /// Keys of those whose gap is below -least (m), confirmed: no deeper than `reach` (m). Of nodes: slaves on
  /// `side`. Of mortar faces: averages for the slave side, single nodes of both that these leave inside for the
  /// other. Of volumes: all, whatever `side` and `least`.
  virtual std::vector<std::int32_t> violated(const Points& x, double reach, const ContactSurface& side,
                                             double least) = 0;
  /// Whether there can be a constraint of this key.
  virtual bool knows(std::int32_t key) const = 0;
  /// Key -1 where there is nothing to hold apart. Its `depth` is how deep others may have left it.
  virtual Constraint at(std::int32_t key, const Points& x, double reach) = 0;
  /// What is pressed on a side; of mortar faces averages of the slave side for either, with single nodes of
  /// `side`.
  virtual std::vector<PressedNode> pressed(const ContactSurface& side, const Contact& contact,
                                           const Points& x) = 0;
  /// (n) Pa at the nodes of both surfaces, zero elsewhere.
  virtual Vector pressure(const Contact& contact, const Points& x) = 0;
};

}  // namespace plica
