#pragma once
#include "plica/dynamics/symmetric_part.hpp"
#include "plica/tissue/strain.hpp"

namespace plica {

/// What the tissue of a scene has come to, of a symmetric one by cells of the whole.
class TissueWatch {
 public:
  /// The cells of the scene; part: of a symmetric one, else null. Both must outlive it.
  TissueWatch(const TetMesh& mesh, const SymmetricPart* part, StrainMeasure measure = StrainMeasure::small);

  /// Under a displacement of the motion's unknowns (m), a mesh's or a part's.
  Strains strains(const Vector& displacement);
  /// Cells inside out or folded over at positions x (n, 3) m of all nodes.
  std::ptrdiff_t folded(const Points& x) const { return folded_cells(x, mesh_.cells); }
  /// (layers) The same in each layer, of the displacement whose strains were last asked for, at less cost.
  Indices folded_since(const Points& x) const;

 private:
  const TetMesh& mesh_;
  const SymmetricPart* part_;
  StrainGauge gauge_;
};

}  // namespace plica
