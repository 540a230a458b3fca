#pragma once
#include "plica/contact/complementarity.hpp"
#include "plica/contact/surface.hpp"
#include "plica/dynamics/distant_values.hpp"
#include "plica/dynamics/reduced_contact.hpp"
#include "plica/dynamics/scene.hpp"

namespace plica {

/// The contact of a fold with its own mirror image in x = 0. A node behind the image's surface is behind the
/// plane, and the forces that keep both apart are along x: gaps are x >= 0 of the part's nodes, linear in the
/// coordinates, and nothing has to be detected (docs/theory.md, "Contact of mirror images").
class MirrorContact final : public ReducedContact {
 public:
  /// See reduced_contact; the scene has a symmetry.
  MirrorContact(const Scene& scene, const Motion& full, const ModalMotion& motion);

  void begin(const State& last) override;
  void touch(const Vector& free) override;
  std::pair<std::vector<std::int32_t>, Vector> closed() const override;
  bool knows(std::int32_t key) const override { return key >= 0 && key < nodes_.size(); }
  bool anywhere(const std::function<bool(const Vector3&)>& place) const override;
  ContactRecord record(const State& now) override;
  void restore(const State& state) override;
  Vector pressure() const override;
  Vector force(const Vector& interface_force) const override;
  void require_open_beyond(const Points&) const override {}  // it looks everywhere

 private:
  std::vector<std::int32_t> own_nodes(const ContactPart& part, const Motion& full) const;
  /// Adds those rows whose x, moved by `shift` (rows) m, is below -least (m).
  bool add_candidates(const Vector& shift, double least);
  Complementarity solve(const Vector& x) const;
  Vector3 position(std::int32_t node, const Vector& q) const;  // of a node on its side
  /// What is pressed on one side at coordinates q by forces (rows) N.
  std::vector<PressedNode> pressed(const Vector& force, const Vector& q) const;
  double inertia() const { return motion_.scheme().beta * motion_.step() * motion_.step(); }

  // A row is one of nodes(), its x and the force along it.
  const ModalMotion& motion_;
  const MirrorImages& images_;
  std::optional<ContactSurface> side_;  // that of the part, in the mesh's numbers
  const Points& reference_;             // (n, 3) m
  bool first_is_own_;                   // whether that side is the contact's first
  double tolerance_;                    // m, of gaps
  Vector images_of_;                    // (rows) how many nodes each moves with it, itself included
  DistantValues x_;                     // (rows) m, without contact
  Eigen::MatrixXd loads_;               // (r, rows) Phi^T of 1 N on a row's node and its images
  Eigen::MatrixXd accelerations_;       // (r, rows) A^-1 of these
  Eigen::MatrixXd compliance_;          // (rows, rows) 1/kg, x of these
  Eigen::MatrixXd side_shapes_;         // (r, 3 nodes of the side)
  std::vector<std::int32_t> place_;     // of a node of the mesh among these
  std::vector<PressedNode> pressed_;    // of the last record

  // Of the step.
  const State* last_ = nullptr;
  Vector free_;                     // (r) of the last move, without contact
  double deepest_ = 0.0;            // m, <= 0: least x with contact
  std::vector<std::int32_t> rows_;  // candidates, ascending
  std::vector<char> active_;        // of these
  Vector row_force_;                // (rows) N
  int passes_ = 0, pivots_ = 0;
};

}  // namespace plica
