#pragma once
#include <optional>
#include <string>

#include "plica/dynamics/record.hpp"
#include "plica/mesh/tet_mesh.hpp"

namespace plica {

/// The step after which tissue cells were folded for the first time.
struct FoldedTissue {
  std::int64_t step = 0;
  std::int64_t count = 0;           // cells
  std::int32_t cell = 0;            // the lowest of them
  Vector3 place = Vector3::Zero();  // m, its centre then
};

/// The step in which an iteration ran out for the first time.
struct Unconverged {
  std::int64_t step = 0;
  double left = 0.0;  // what was above its tolerance
};

/// Troubles that a step outlives, each as it came first: where a later failure comes from.
struct FirstSigns {
  std::optional<Unconverged> coupling;  // left: subglottal pressures
  std::optional<Unconverged> contact;   // left: m of gap error
  std::optional<FoldedTissue> folded_tissue;

  /// Notes what is new in a step that ended at positions x (n, 3).
  void note(std::int64_t step, const StepRecord& record, const Points& x, const Cells& cells);
  /// Throws InvalidInput where one is of a later step than `last`, or of no cell.
  void validate(std::int64_t last, std::ptrdiff_t cells) const;
  /// " First sign: ..." in the order in which they came and what to try about the first; empty without any.
  /// Steps of h s; `folded_now` of the tissue's `cells` are folded at the end of the last step.
  /// linear: whether the tissue is.
  std::string text(double h, std::ptrdiff_t folded_now, std::ptrdiff_t cells, bool linear = true) const;
};

}  // namespace plica
