#pragma once
#include <array>
#include <utility>

#include "plica/contact/airway.hpp"
#include "plica/contact/constraint.hpp"
#include "plica/contact/surface.hpp"

namespace plica {

/// A slave node facing the point of a master triangle (its foot), Paper A, Eqs. (18)-(20). The force p acts along
/// the normal n on the slave and -w_k n on the masters, so both sides sum to zero. n is the mean of both surfaces'
/// smooth normals: it does not jump from triangle to triangle, and a pair seen from either side is the same. The
/// gap is the distance to the surface along n, gap = g . (x_s - sum_k w_k x_k), with g . n = 1 and g across the
/// directions in which the foot follows the slave: along the triangle's own normal where the foot is inside,
/// across the edge on an edge, n itself on a corner. n is turned to within 60 degrees of g where it leans further.
struct Pair {
  std::int32_t key = -1;    // what the pair stands for from pass to pass: its slave node, or its tetrahedron
  std::int32_t slave = -1;  // node
  std::array<std::int32_t, 3> master{};
  Vector3 weights = Vector3::Zero();
  Vector3 normal = Vector3::Zero();  // unit, from the master's tissue towards the slave's: direction of the force
  Vector3 gradient = Vector3::Zero();  // of the gap, gradient . normal = 1
  double stiffness = 0.0;              // N/m of a volume pair, else 0

  /// x_s - sum_k w_k x_k, m.
  Vector3 offset(const Points& x) const {
    Vector3 d = x.row(slave);
    for (int k = 0; k < 3; ++k) d -= weights[k] * x.row(master[static_cast<std::size_t>(k)]).transpose();
    return d;
  }
  double gap(const Points& x) const { return gradient.dot(offset(x)); }
  /// Whether the slave really lies behind the master: behind it along the gap's gradient, no further than the
  /// `reach` (m) that the motion since it was outside allows, and the way to the foot is along the gradient rather
  /// than across it, within 60 degrees. Over a face the gradient is along that way, however the normals lean.
  /// (Beside or across from a strongly bent surface a gap can be negative although nothing has crossed.)
  bool penetrates(const Points& x, double reach) const {
    const Vector3 d = offset(x);
    const double behind = -gradient.dot(d) / gradient.norm();
    return behind > 0 && behind <= reach && 4 * behind * behind >= d.squaredNorm();
  }
  /// The pair as what is solved for; masters without weight are left out.
  Constraint constraint() const;
};

/// Two edges of the two surfaces that have passed through each other while no node has.
struct EdgeCrossing {
  Vector3 place;
  double volume;  // m^3, of the inverted tetrahedron, > 0
};

/// A part of an airway that does not change: numbers of its triangles and tetrahedra, ascending.
struct Neighbourhood {
  std::vector<std::int32_t> first, second, tets;
};

/// Finds what overlaps: an inverted airway tetrahedron names candidates, the sign of the gap decides.
/// In an airway that is renewed the faces of the tetrahedra need not be those of the surfaces, so all nodes near
/// the other surface are candidates, and tetrahedra thinner than what that can hide name them too.
class Detector {
 public:
  /// Throws InvalidInput for a node number of the airway outside reference (n, 3), or an empty surface.
  Detector(Airway airway, const Points& reference);

  const Airway& airway() const { return airway_; }
  const ContactSurface& first() const { return first_; }
  const ContactSurface& second() const { return second_; }
  bool slave_is_first() const { return slave_is_first_; }
  /// The side whose nodes are slaves first: the finer one, or the first of two alike.
  const ContactSurface& slave_side() const { return slave_is_first_ ? first_ : second_; }
  const ContactSurface& master_side() const { return slave_is_first_ ? second_ : first_; }
  /// The node of the other surface that this one faces at rest, or -1.
  std::int32_t partner(std::int32_t node) const { return partner_[static_cast<std::size_t>(node)]; }
  /// Of the mesh that both surfaces belong to.
  std::int32_t node_count() const { return static_cast<std::int32_t>(partner_.size()); }
  /// Whether this is a node of either surface; any number may be asked for.
  bool contains(std::int32_t node) const {
    return node >= 0 && node < node_count() && (first_.contains(node) || second_.contains(node));
  }
  /// Nodes of both surfaces, ascending.
  const Indices& nodes() const { return nodes_; }
  double mean_edge() const { return mean_edge_; }  // m, of the reference surfaces

  /// Triangulates the air anew at positions x (n, 3), the surfaces being at most `depth` (m) inside each other
  /// there. Nothing where the airway never changes. The keys of volume_pair change.
  void renew(const Points& x, double depth);
  /// Looks from the next update on at a part alone, which must have all tetrahedra that can be inside out.
  void look_at(const Neighbourhood& part);
  void look_everywhere();
  /// Whether since the last call a pair's foot was on the rim of what is looked at: then it may be another.
  bool take_foot_on_rim() { return std::exchange(foot_on_rim_, false); }

  /// Takes up positions x (n, 3): normals, areas, inverted tetrahedra. Only rows of nodes() are read.
  void update(const Points& x);
  /// Tetrahedra that are inside out at the positions of the last update.
  const std::vector<std::int32_t>& inverted_tets() const { return inverted_; }
  /// Nodes of `side` in inverted (airway that is renewed: or thin) tetrahedra, without those common to both
  /// surfaces, ascending.
  std::vector<std::int32_t> candidates(const ContactSurface& side) const;
  /// The pairs of the nodes of `side` that penetrate at x, the positions of the last update, by slave: of those
  /// candidates, in an airway that is renewed of all no further than `reach` (m) from the other surface.
  std::vector<Pair> inside(const ContactSurface& side, const Points& x, double reach);

  /// The pair of a slave node at x, the positions of the last update: closest point of the other surface; the
  /// normal is the mean of the master's and the reversed slave's, so that a pair seen from either side is the same
  /// constraint. It is found once an update.
  const Pair& pair(std::int32_t slave, const Points& x);
  /// The pair of the thesis's volume penalty (Eq. 28) for an airway tetrahedron with one node on one side:
  /// weights 1/3, the face's own normal, gap = 3 V / A, stiffness kappa A / 12. Key -1 for edge to edge, and for a
  /// face without area.
  Pair volume_pair(std::int32_t tet, const Points& x, double kappa) const;
  /// Edge-to-edge tetrahedra whose edges have really crossed: the closest points of the two edges are
  /// inner ones and lie on the wrong side of each other.
  std::vector<EdgeCrossing> edge_crossings(const Points& x, double reach) const;
  /// The node that is deepest inside the other surface, and its gap (m, < 0); node -1 and gap 0 where none is.
  struct Deepest {
    std::int32_t node = -1;
    double gap = 0.0;
  };
  Deepest deepest(const Points& x, double reach);
  /// Sum of |V| over inverted tetrahedra with one node on one side whose slave penetrates, m^3.
  double overlap_volume(const Points& x, double reach);
  /// How far a node that touches has slid along the other surface from the node that it faces at rest, m: by that
  /// its airway knows less of what it faces. 0 where the airway is renewed, or joins it to nothing.
  double slide(std::int32_t node, const Points& x) const;
  /// Largest depth (m) that two surfaces can have at x if they were `depth` (m) deep at `before`: twice the
  /// largest displacement of a surface node, plus that depth.
  double reach(const Points& before, const Points& x, double depth) const;

 private:
  void join();  // partner_, from the tetrahedra
  Pair found_pair(std::int32_t slave, const Points& x);
  void forget_pairs();
  /// Tetrahedra no higher than a surface bulges from the tangent planes of their nodes.
  void find_thin(const Points& x);

  Airway airway_;
  Points reference_;
  ContactSurface first_, second_;
  Indices nodes_;
  double mean_edge_ = 0.0;
  bool slave_is_first_ = true;
  std::vector<std::int32_t> shown_;  // tetrahedra looked at
  bool foot_on_rim_ = false;
  std::vector<Pair> pairs_;              // (n) those found since the last update: their slave is their node
  std::vector<std::int32_t> paired_;     // nodes that have one
  std::vector<std::int32_t> last_foot_;  // (n) triangle of the foot found last, or -1
  std::vector<std::int32_t> inverted_, thin_;
  std::vector<std::int32_t>
      partner_;  // (n) of the other surface's nodes that share an airway tetrahedron the one it faces
};

}  // namespace plica
