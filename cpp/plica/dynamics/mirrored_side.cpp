#include "plica/dynamics/mirrored_side.hpp"

#include <Eigen/Geometry>

#include "plica/core/error.hpp"
#include "plica/core/panel_matrix.hpp"

namespace plica {

namespace {

/// Whether a surface lies in x >= 0, judged by where most of it is.
bool is_own(const Triangles& side, const Points& x) {
  double sum = 0;
  for (const std::int32_t node : side.reshaped()) sum += x(node, 0);
  return sum > 0;
}

}  // namespace

MirroredSide::MirroredSide(const ContactPart& part, const Motion& full, const ModalMotion& motion)
    : images_(*full.images()), reference_(full.reference()), is_first_(is_own(part.airway.first, reference_)) {
  if (is_first_ == is_own(part.airway.second, reference_))
    throw InvalidInput(
        "Reduction: with symmetry the contact's surfaces must be each other's mirror image in x = 0.");
  surface_.emplace(is_first_ ? part.airway.first : part.airway.second, reference_.rows());
  for (const std::int32_t node : surface_->nodes()) {
    const std::int32_t own = images_.node_of(node);
    // What is held along x, in the plane or elsewhere, neither opens nor closes.
    if (images_.nodes()[own] == node && !full.supports().fixed(3 * static_cast<std::ptrdiff_t>(own)))
      crossing_.push_back(node);
  }
  if (crossing_.empty())
    throw InvalidInput("Reduction: no node of the contact's surfaces can move across the plane x = 0; one must.");
  const ContactSurface other(is_first_ ? part.airway.second : part.airway.first, reference_.rows());
  for (const std::int32_t node : crossing_)
    if (!other.contains(images_.partner(0, node)))
      throw InvalidInput("Reduction: with symmetry the mirror image of node " + std::to_string(node) +
                         " in x = 0 must be on the contact's other surface; is not.");
  const Indices all =
      Eigen::Map<const Indices>(surface_->nodes().data(), static_cast<std::ptrdiff_t>(surface_->nodes().size()));
  shapes_ = motion.shapes_at(all).transpose();
  place_.assign(static_cast<std::size_t>(reference_.rows()), -1);
  for (std::int32_t i = 0; i < all.size(); ++i) place_[static_cast<std::size_t>(all[i])] = i;
}

Vector3 MirroredSide::position(std::int32_t node, const Vector& q) const {
  const std::ptrdiff_t at = 3 * static_cast<std::ptrdiff_t>(place_[static_cast<std::size_t>(node)]);
  Vector3 x = reference_.row(node);
  for (int c = 0; c < 3; ++c) x[c] += inner_product(shapes_.col(at + c), q);
  return x;
}

std::vector<PressedNode> MirroredSide::pressed(const Indices& nodes, const Vector& force, const Vector& q) const {
  std::vector<PressedNode> found;
  Points x(reference_.rows(), 3);  // of the nodes around those that are pressed
  std::vector<char> known(static_cast<std::size_t>(reference_.rows()), 0);
  for (std::ptrdiff_t i = 0; i < force.size(); ++i) {
    if (!(force[i] > 0)) continue;
    const std::int32_t node = nodes[i];
    double area = 0;
    for (const std::int32_t triangle : surface_->fan(node)) {
      const auto corners = surface_->triangles().row(triangle);
      for (const std::int32_t corner : corners)
        if (char& is_known = known[static_cast<std::size_t>(corner)]; !is_known) {
          x.row(corner) = position(corner, q);
          is_known = 1;
        }
      const Vector3 a = x.row(corners[0]), b = x.row(corners[1]), c = x.row(corners[2]);
      area += (b - a).cross(c - a).norm() / 6.0;
    }
    const auto [from, to] = surface_->tributary_stretch(node, x);
    found.push_back({node, area, force[i] / area, {from, to}});
    if (images_.planes() > 1 && images_.partner(1, node) != node)
      found.push_back({images_.partner(1, node), area, force[i] / area, {-to, -from}});
  }
  return found;
}

}  // namespace plica
