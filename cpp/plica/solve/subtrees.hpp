#pragma once
#include <functional>

#include "plica/solve/supernodes.hpp"

namespace plica {

/// Which supernodes the threads take on their own: subtrees that share nothing, and the few above them.
class Subtrees {
 public:
  explicit Subtrees(const Supernodes& tree);
  /// Calls act(s) for every supernode, children before parents, subtrees in parallel on the threads that are set.
  void upward(const std::function<void(std::int32_t)>& act) const;
  /// Parents before children.
  void downward(const std::function<void(std::int32_t)>& act) const;

 private:
  struct Division {
    std::vector<std::int32_t> begin, end;  // of each subtree's supernodes, the heaviest subtree first
    std::vector<std::int32_t> above;       // ascending
  };
  const Division& division() const;

  std::vector<Division> divisions_;  // for 1, 2, 4, ... threads
};

}  // namespace plica
