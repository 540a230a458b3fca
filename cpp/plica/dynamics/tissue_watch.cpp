#include "plica/dynamics/tissue_watch.hpp"

namespace plica {

TissueWatch::TissueWatch(const TetMesh& mesh, const SymmetricPart* part)
    : mesh_(mesh), part_(part), gauge_(part ? part->mesh : mesh) {}

Strains TissueWatch::strains(const Vector& displacement) {
  Strains strains = gauge_.measure(displacement);
  if (part_) strains.cell = part_->images.cells()[strains.cell];
  return strains;
}

int TissueWatch::folded_since(const Points& x) const {
  const std::vector<std::int32_t>& suspects = gauge_.suspects();
  if (!part_) return static_cast<int>(folded_cells(x, mesh_.cells, suspects));
  std::vector<std::int32_t> in_whole;
  for (const std::int32_t cell : suspects) in_whole.push_back(part_->images.cells()[cell]);
  return part_->images.copies() * static_cast<int>(folded_cells(x, mesh_.cells, in_whole));
}

}  // namespace plica
