#include "plica/dynamics/mediolateral.hpp"

namespace plica {

Mediolateral::Mediolateral(const Motion& full, const ModalMotion& motion, const std::vector<std::int32_t>& contact,
                           const std::vector<std::int32_t>& others)
    : images_(full.images()), place_(static_cast<std::size_t>(motion.shapes().rows() / 3), -1) {
  std::vector<std::int32_t> nodes;
  const auto take = [&](const std::vector<std::int32_t>& more) {
    for (const std::int32_t node : more) {
      std::int32_t& place = place_[static_cast<std::size_t>(node)];
      if (place >= 0) continue;
      place = static_cast<std::int32_t>(nodes.size());
      nodes.push_back(node);
    }
  };
  take(contact);
  const auto of_contact = static_cast<std::ptrdiff_t>(nodes.size());
  take(others);
  const auto count = static_cast<std::ptrdiff_t>(nodes.size());
  rest_.resize(count);
  shapes_.resize(count, motion.size());
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    const std::int32_t node = nodes[static_cast<std::size_t>(i)];
    rest_[i] = full.reference()(images_ ? images_->nodes()[node] : node, 0);
    shapes_.row(i) = motion.shapes().row(3 * static_cast<std::ptrdiff_t>(node));
  }
  panels_ = PanelMatrix(shapes_);
  contact_panels_ = PanelMatrix(shapes_.topRows(of_contact));
}

}  // namespace plica
