#pragma once
#include <memory>
#include <optional>

#include "plica/core/types.hpp"

namespace plica {

class LastBasis;

/// What a scene's displacement is reduced to: combinations of the columns of a basis, e.g. modes of vibration and
/// static responses to what presses on it. Flow, contact and the energy ledger are those of the full scene.
struct Reduction {
  Eigen::MatrixXd basis;  // (3 n, any number): the displacement is one of its combinations
  int watch_every = 20;   // steps, >= 1, between two looks at strains and folded tissue, which take the whole mesh
  /// -, in (0, 1]: of critical, of every coordinate, in place of what the viscosity of materials damps.
  std::optional<double> damping_ratio = {};
  /// Of scenes that are made one after another, each with this: what does not change is not made anew. Null: it
  /// is.
  std::shared_ptr<LastBasis> last = {};
  void validate(std::ptrdiff_t nodes) const;  // throws InvalidInput
};

}  // namespace plica
