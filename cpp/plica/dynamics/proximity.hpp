#pragma once
#include <array>

#include "plica/contact/pairs.hpp"
#include "plica/core/panel_matrix.hpp"

namespace plica {

/// Nodes of an airway at rest x (n, 3) m, first and second, that face each other, those common to both left out;
/// none where it does not say along which direction.
std::vector<std::array<std::int32_t, 2>> facing_pairs(const Airway& airway, const Points& x);

/// Which part of two surfaces that face each other can touch, from the coordinates of a reduction. Nodes that face
/// each other are apart as long as their distance along the facing direction is more than twice what they have
/// slid past each other. Those for which little is left are near, and what is around them is looked at until
/// others are (docs/reduction.md, "Contact"): contact costs what is near, and what it finds does not depend on
/// what was looked at.
class Proximity {
 public:
  /// An airway numbered so that nodes at rest x (m, 3) m are moved by shapes (3 m, r).
  Proximity(const Airway& airway, const Points& x, const Eigen::MatrixXd& shapes);

  /// Takes for near what at coordinates q is, or comes within `ahead` (m) more of motion, and these nodes.
  void choose(const Vector& q, double ahead, const std::vector<std::int32_t>& touching);
  /// Whether nothing else can touch at coordinates q.
  bool holds_at(const Vector& q);
  /// Whether what is near can; only where that holds.
  bool can_touch(const Vector& q) const { return pairs_.empty() || !(apart_ > 1.001 * closed(q - seen_at_)); }
  /// Whether this node is near.
  bool is_near(std::int32_t node) const { return pairs_.empty() || near_[static_cast<std::size_t>(node)] != 0; }
  /// Whether everything is, always: the airway does not say along which direction its nodes face each other.
  bool everything() const { return pairs_.empty(); }
  /// What is near, and as many rings of triangles around it.
  Neighbourhood surroundings(int rings) const;

  /// Bounds of what a change of the coordinates moves, m: any node, and any two that face each other past or
  /// towards each other.
  double moved(const Vector& dq) const { return speed_.dot(dq.cwiseAbs()); }
  double closed(const Vector& dq) const { return closing_speed_.dot(dq.cwiseAbs()); }

 private:
  struct Side {
    Triangles triangles;
    std::vector<std::vector<std::int32_t>> fans;  // (m) triangles of a node
  };
  std::vector<std::int32_t> around(const Side& side, int rings) const;
  /// (p) m by how much the nodes of a pair are apart at coordinates q, over twice what they have slid.
  Eigen::VectorXf gaps(const Vector& q) const;
  /// Takes up the gaps at q.
  void see(const Vector& q, const Eigen::VectorXf& gaps);

  Vector3 facing_;
  float round_off_;  // m
  std::array<Side, 2> sides_;
  Tets tets_;
  std::vector<std::array<std::int32_t, 2>> pairs_;
  Eigen::VectorXf offsets_;       // (3 p) m, from the nodes of one surface to those that face them, at rest
  SinglePanelMatrix shapes_;      // (3 p, r)
  Vector speed_, closing_speed_;  // (r) m, largest over nodes and pairs

  // Near are:
  std::vector<char> near_pairs_;   // (p)
  std::vector<char> near_;         // (m) nodes, all of these tetrahedra
  std::vector<std::int32_t> air_;  // tetrahedra
  // When gaps were last taken up:
  Vector seen_at_;
  double left_ = -1.0;   // m, least gap of what is not near; < 0 before the first
  double apart_ = -1.0;  // m, of what is
};

}  // namespace plica
