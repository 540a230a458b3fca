#include <algorithm>
#include <cmath>

#include "plica/core/error.hpp"
#include "plica/mesh/larynx_parts.hpp"

namespace plica {

double minor_at(const Larynx::Shape& shape, double z) {
  const auto& s = shape.sections;
  std::size_t k = 1;
  while (k + 1 < s.size() && s[k].z <= z) ++k;
  const double f = (z - s[k - 1].z) / (s[k].z - s[k - 1].z);
  return (1 - f) * s[k - 1].minor + f * s[k].minor;
}

LarynxLayers::LarynxLayers(const Larynx::Shape& shape) : shape_(shape) {
  const auto& s = shape.sections;
  const int from = shape.layers_from_section, to = shape.layers_to_section;
  const bool level = shape.layers_along == Larynx::LayersAlong::level;
  const LayerDepths thickness{shape.layer_thickness, shape.ligament_thickness.value_or(shape.layer_thickness)};
  if (level) level_ = thickness;
  for (const int layer : {1, 2}) {
    auto& line = layer == 1 ? cover_ : ligament_;
    const double outer = thickness.cover + (layer == 1 ? 0.0 : thickness.ligament);
    const auto slope = [&](int k) { return (s[k + 1].minor - s[k].minor) / (s[k + 1].z - s[k].z); };
    // Seen level, what is parallel to a piece of slope a' at the distance t lies deeper by t sqrt(1 + a'^2).
    const auto depth = [&](int k) { return outer * (level ? 1.0 : std::hypot(1, slope(k))); };
    line.push_back({s[from].z, s[from].minor + depth(from)});
    for (int k = from + 1; k < to; ++k) {
      // The mitre: where the parallels of two pieces meet.
      const double deeper = depth(k - 1) - depth(k);
      const double up = deeper == 0 ? 0 : deeper / (slope(k) - slope(k - 1)), z = s[k].z + up;
      if (!(z > line.back().z) || !(z < s[to].z))
        throw InvalidInput(
            "Larynx", "layer_thickness", shape.layer_thickness, "m",
            "less: along the normal the layers run into each other at section " + std::to_string(k));
      line.push_back({z, s[k].minor + up * slope(k) + depth(k)});
    }
    line.push_back({s[to].z, s[to].minor + depth(to - 1)});
  }
}

LayerDepths LarynxLayers::at(double z) const {
  if (level_) return *level_;
  z = std::clamp(z, cover_.front().z, cover_.back().z);
  const auto x = [&](const std::vector<Bend>& line) {
    std::size_t k = 1;
    while (line[k].z < z) ++k;
    const double f = (z - line[k - 1].z) / (line[k].z - line[k - 1].z);
    return (1 - f) * line[k - 1].x + f * line[k].x;
  };
  const double cover = x(cover_);
  return {cover - minor_at(shape_, z), x(ligament_) - cover};
}

std::vector<double> LarynxLayers::bends(int layer) const {
  std::vector<double> heights;
  for (const Bend& bend : layer == 1 ? cover_ : ligament_) heights.push_back(bend.z);
  return heights;
}

}  // namespace plica
