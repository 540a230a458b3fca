#include "plica/solve/subtrees.hpp"

#include <algorithm>

#include "plica/core/threads.hpp"

namespace plica {
namespace {

constexpr int most_threads = 16;

}  // namespace

Subtrees::Subtrees(const Supernodes& tree) {
  const std::int32_t count = tree.count();
  std::vector<std::ptrdiff_t> own(static_cast<std::size_t>(count)), below(own.size());
  std::vector<std::int32_t> lowest(own.size());  // first supernode of the subtree, which is [lowest, root]
  std::vector<std::int32_t> open;                // roots of the subtrees
  for (std::int32_t s = 0; s < count; ++s) {
    own[s] = panel_floats(tree.columns(s), tree.rows(s));
    below[s] += own[s];
    lowest[s] = tree.children[s].empty() ? s : lowest[tree.children[s].front()];
    if (tree.parent[s] < 0)
      open.push_back(s);
    else
      below[tree.parent[s]] += below[s];
  }
  const auto heavier = [&](std::int32_t a, std::int32_t b) {
    return below[a] != below[b] ? below[a] > below[b] : a < b;
  };
  for (int threads = 1; threads <= most_threads; threads *= 2) {
    // The heaviest subtree is split again and again; kept is what the slowest thread and the supernodes above
    // take least of, each subtree given to the thread with the least to do.
    std::vector<std::int32_t> roots = open, above, best_roots = open, best_above;
    std::ptrdiff_t best = -1, top = 0;
    for (int split = 0; split <= 8 * threads && !roots.empty(); ++split) {
      std::sort(roots.begin(), roots.end(), heavier);
      std::vector<std::ptrdiff_t> load(static_cast<std::size_t>(threads), 0);
      for (const std::int32_t root : roots) *std::min_element(load.begin(), load.end()) += below[root];
      const std::ptrdiff_t time = top + *std::max_element(load.begin(), load.end());
      if (best < 0 || time < best) best = time, best_roots = roots, best_above = above;
      const std::int32_t root = roots.front();
      top += own[root];
      above.push_back(root);
      roots.erase(roots.begin());
      roots.insert(roots.end(), tree.children[root].begin(), tree.children[root].end());
    }
    Division division;
    for (const std::int32_t root : best_roots) {
      division.begin.push_back(lowest[root]);
      division.end.push_back(root + 1);
    }
    std::sort(best_above.begin(), best_above.end());
    division.above = std::move(best_above);
    divisions_.push_back(std::move(division));
  }
}

const Subtrees::Division& Subtrees::division() const {
  std::size_t k = 0;
  while (k + 1 < divisions_.size() && (2 << k) <= threads()) ++k;
  return divisions_[k];
}

void Subtrees::upward(const std::function<void(std::int32_t)>& act) const {
  const Division& d = division();
  for_chunks(static_cast<std::ptrdiff_t>(d.begin.size()), 1,
             [&](std::ptrdiff_t begin, std::ptrdiff_t, std::ptrdiff_t) {
               for (std::int32_t s = d.begin[begin]; s < d.end[begin]; ++s) act(s);
             });
  for (const std::int32_t s : d.above) act(s);
}

void Subtrees::downward(const std::function<void(std::int32_t)>& act) const {
  const Division& d = division();
  for (auto s = d.above.rbegin(); s != d.above.rend(); ++s) act(*s);
  for_chunks(static_cast<std::ptrdiff_t>(d.begin.size()), 1,
             [&](std::ptrdiff_t begin, std::ptrdiff_t, std::ptrdiff_t) {
               for (std::int32_t s = d.end[begin] - 1; s >= d.begin[begin]; --s) act(s);
             });
}

}  // namespace plica
