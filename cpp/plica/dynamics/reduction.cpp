#include "plica/dynamics/reduction.hpp"

#include <string>

#include "plica/core/error.hpp"

namespace plica {

void Reduction::validate(std::ptrdiff_t nodes) const {
  if (basis.rows() != 3 * nodes)
    throw InvalidInput("Reduction", "rows of the basis", static_cast<double>(basis.rows()), "",
                       "3 times the " + std::to_string(nodes) + " nodes");
  if (basis.cols() < 1 || basis.cols() > basis.rows())
    throw InvalidInput("Reduction", "vectors of the basis", static_cast<double>(basis.cols()), "",
                       "in [1, " + std::to_string(basis.rows()) + "]");
  if (!basis.allFinite()) throw InvalidInput("Reduction: the basis has a value that is not finite.");
  if (damping_ratio && !(*damping_ratio > 0 && *damping_ratio <= 1))
    throw InvalidInput("Reduction", "damping_ratio", *damping_ratio, "", "in (0, 1]",
                       "It is a share of the critical damping.");
  if (watch_every < 1) throw InvalidInput("Reduction", "watch_every", watch_every, "steps", ">= 1");
}

}  // namespace plica
