#include "plica/dynamics/tissue_watch.hpp"

namespace plica {

TissueWatch::TissueWatch(const TetMesh& mesh, const SymmetricPart* part, StrainMeasure measure)
    : mesh_(mesh), part_(part), gauge_(part ? part->mesh : mesh, measure) {}

Strains TissueWatch::strains(const Vector& displacement) {
  Strains strains = gauge_.measure(displacement);
  if (part_) strains.cell = part_->images.cells()[strains.cell];
  return strains;
}

Indices TissueWatch::folded_since(const Points& x) const {
  std::vector<std::vector<std::int32_t>> suspects(
      mesh_.layer_names.size());  // of each layer, by cells of the whole
  for (std::int32_t cell : gauge_.suspects()) {
    if (part_) cell = part_->images.cells()[cell];
    suspects[static_cast<std::size_t>(mesh_.cell_layer[cell])].push_back(cell);
  }
  Indices folded(static_cast<std::ptrdiff_t>(suspects.size()));
  for (std::ptrdiff_t layer = 0; layer < folded.size(); ++layer)
    folded[layer] =
        static_cast<std::int32_t>(folded_cells(x, mesh_.cells, suspects[static_cast<std::size_t>(layer)]));
  return part_ ? Indices(part_->images.copies() * folded) : folded;
}

}  // namespace plica
