#include "plica/solve/bisection.hpp"

#include <algorithm>
#include <array>
#include <queue>

namespace plica {
namespace {

constexpr int left = static_cast<int>(Half::left), separator = static_cast<int>(Half::separator);

int index(Half half) { return static_cast<int>(half); }
Half other(Half half) { return half == Half::left ? Half::right : Half::left; }

/// What a division is judged by: too heavy a side, then the separator, the dearer the more the sides differ.
struct Cost {
  std::int64_t excess, separator, difference;
  bool operator<(const Cost& o) const {
    if (excess != o.excess) return excess < o.excess;
    return separator != o.separator ? separator < o.separator : difference < o.difference;
  }
};

/// A division that is improved by moving nodes from the separator to a side; neighbours on the other side enter
/// the separator in their place.
class Division {
 public:
  Division(const Graph& graph, std::vector<Half>& half) : graph_(graph), half_(half) {
    for (std::int32_t v = 0; v < graph.size(); ++v) weight_[index(half[v])] += graph.weight[v];
    total_ = weight_[0] + weight_[1] + weight_[2];
    limit_ = 11 * total_ / 20;
    for (auto& gain : gain_) gain.resize(graph.weight.size());
  }

  Cost cost() const {
    const std::int64_t difference = std::abs(weight_[0] - weight_[1]);
    return {std::max<std::int64_t>(0, std::max(weight_[0], weight_[1]) - limit_),
            weight_[separator] * (total_ + 2 * difference), difference};
  }

  void refine() {
    constexpr int passes = 8;
    for (int pass = 0; pass < passes && improve(); ++pass) {
    }
  }

 private:
  struct Candidate {
    std::int64_t gain;
    std::int32_t node;
    Half to;
    bool operator<(const Candidate& o) const {
      if (gain != o.gain) return gain < o.gain;
      return node != o.node ? node > o.node : index(to) > index(o.to);
    }
  };
  struct Move {
    std::int32_t node;
    Half to;
    std::vector<std::int32_t> pulled;
  };

  template <typename Act>
  void for_neighbours(std::int32_t v, const Act& act) const {
    for (std::int32_t e = graph_.start[v]; e < graph_.start[v + 1]; ++e) act(graph_.neighbour[e]);
  }

  void put(std::int32_t v, Half to) {
    weight_[index(half_[v])] -= graph_.weight[v];
    weight_[index(to)] += graph_.weight[v];
    half_[v] = to;
  }

  void offer(std::int32_t v, Half to) {
    if (!moved_[v]) candidates_.push({gain_[index(to)][v], v, to});
  }

  /// Computes what moving v to either side gains.
  void enter(std::int32_t v) {
    for (const Half to : {Half::left, Half::right}) {
      std::int64_t gain = graph_.weight[v];
      for_neighbours(v, [&](std::int32_t u) {
        if (half_[u] == other(to)) gain -= graph_.weight[u];
      });
      gain_[index(to)][v] = gain;
      offer(v, to);
    }
  }

  void change_gain(std::int32_t v, Half to, std::int64_t by) {
    gain_[index(to)][v] += by;
    offer(v, to);
  }

  Move move(std::int32_t v, Half to) {
    Move done{v, to, {}};
    put(v, to);
    moved_[v] = 1;
    for_neighbours(v, [&](std::int32_t u) {
      if (half_[u] == other(to)) done.pulled.push_back(u);
      if (half_[u] == Half::separator) change_gain(u, other(to), -graph_.weight[v]);
    });
    for (const std::int32_t u : done.pulled) {
      put(u, Half::separator);
      for_neighbours(u, [&](std::int32_t x) {
        if (half_[x] == Half::separator && x != u) change_gain(x, to, graph_.weight[u]);
      });
    }
    for (const std::int32_t u : done.pulled) enter(u);
    return done;
  }

  void undo(const Move& done) {
    put(done.node, Half::separator);
    for (const std::int32_t u : done.pulled) put(u, other(done.to));
  }

  /// One pass: every node moves at most once, the best first even at a loss; what came after the best is undone.
  bool improve() {
    constexpr std::size_t patience = 60;  // moves without a new best
    moved_.assign(half_.size(), 0);
    candidates_ = {};
    for (std::int32_t v = 0; v < graph_.size(); ++v)
      if (half_[v] == Half::separator) enter(v);
    const Cost before = cost();
    Cost best = before;
    std::vector<Move> moves;
    std::size_t kept = 0;
    while (!candidates_.empty() && moves.size() < kept + patience) {
      const Candidate next = candidates_.top();
      candidates_.pop();
      const std::int32_t v = next.node;
      if (moved_[v] || half_[v] != Half::separator || gain_[index(next.to)][v] != next.gain) continue;
      const std::int64_t filled = weight_[index(next.to)] + graph_.weight[v];
      if (filled > limit_ && filled > weight_[index(other(next.to))]) continue;
      moves.push_back(move(v, next.to));
      if (cost() < best) {
        best = cost();
        kept = moves.size();
      }
    }
    for (; moves.size() > kept; moves.pop_back()) undo(moves.back());
    return best < before;
  }

  const Graph& graph_;
  std::vector<Half>& half_;
  std::array<std::int64_t, 3> weight_{};
  std::int64_t limit_ = 0, total_ = 0;
  std::array<std::vector<std::int64_t>, 2> gain_;
  std::vector<std::uint8_t> moved_;
  std::priority_queue<Candidate> candidates_;
};

/// The graph whose nodes are pairs of joined nodes, the most strongly joined first, and what is left single.
Graph coarsen(const Graph& fine, std::vector<std::int32_t>& coarse_of) {
  const std::int32_t n = fine.size();
  coarse_of.assign(static_cast<std::size_t>(n), -1);
  std::vector<std::int32_t> visit(static_cast<std::size_t>(n));
  // A scattered order, or the pairs would lie along the numbering: multiplication by an odd number mixes the bits.
  const auto scattered = [](std::int32_t v) { return static_cast<std::uint32_t>(v) * 2654435761u; };
  for (std::int32_t v = 0; v < n; ++v) visit[v] = v;
  std::sort(visit.begin(), visit.end(),
            [&](std::int32_t a, std::int32_t b) { return scattered(a) < scattered(b); });
  std::vector<std::array<std::int32_t, 2>> members;
  for (const std::int32_t v : visit) {
    if (coarse_of[v] >= 0) continue;
    std::int32_t partner = -1, strongest = 0;
    for (std::int32_t e = fine.start[v]; e < fine.start[v + 1]; ++e) {
      const std::int32_t u = fine.neighbour[e];
      if (coarse_of[u] >= 0) continue;
      const bool lighter = partner < 0 || fine.weight[u] < fine.weight[partner];
      if (fine.multiplicity[e] > strongest || (fine.multiplicity[e] == strongest && lighter)) {
        strongest = fine.multiplicity[e];
        partner = u;
      }
    }
    coarse_of[v] = static_cast<std::int32_t>(members.size());
    if (partner >= 0) coarse_of[partner] = coarse_of[v];
    members.push_back({v, partner});
  }
  Graph coarse;
  std::vector<std::int32_t> place(members.size(), -1);  // of a neighbour among this node's
  for (std::int32_t c = 0; c < static_cast<std::int32_t>(members.size()); ++c) {
    const std::int32_t begin = coarse.start.back();
    std::int32_t weight = 0;
    for (const std::int32_t v : members[c]) {
      if (v < 0) continue;
      weight += fine.weight[v];
      for (std::int32_t e = fine.start[v]; e < fine.start[v + 1]; ++e) {
        const std::int32_t u = coarse_of[fine.neighbour[e]];
        if (u == c) continue;
        if (place[u] < begin) {
          place[u] = static_cast<std::int32_t>(coarse.neighbour.size());
          coarse.neighbour.push_back(u);
          coarse.multiplicity.push_back(0);
        }
        coarse.multiplicity[place[u]] += fine.multiplicity[e];
      }
    }
    coarse.weight.push_back(weight);
    coarse.start.push_back(static_cast<std::int32_t>(coarse.neighbour.size()));
  }
  return coarse;
}

/// The nodes in the order of their distance from the first of `queue`, components one after the other.
std::vector<std::int32_t> breadth_first(const Graph& graph, std::int32_t from) {
  std::vector<std::int32_t> queue;
  std::vector<std::uint8_t> seen(graph.weight.size(), 0);
  for (std::int32_t next = -1; next < graph.size(); ++next) {
    const std::int32_t root = next < 0 ? from : next;
    if (seen[root]) continue;
    seen[root] = 1;
    std::size_t at = queue.size();
    for (queue.push_back(root); at < queue.size(); ++at) {
      const std::int32_t v = queue[at];
      for (std::int32_t e = graph.start[v]; e < graph.start[v + 1]; ++e) {
        const std::int32_t u = graph.neighbour[e];
        if (!seen[u]) seen[u] = 1, queue.push_back(u);
      }
    }
  }
  return queue;
}

/// The best of several divisions, each grown from another node to half the weight.
std::vector<Half> divide(const Graph& graph) {
  constexpr std::int32_t trials = 8;
  std::int64_t total = 0;
  for (const std::int32_t weight : graph.weight) total += weight;
  std::vector<Half> best;
  Cost least{};
  const std::int32_t stride = std::max(1, graph.size() / trials);
  for (std::int32_t seed = 0; seed < graph.size(); seed += stride) {
    std::vector<Half> half(graph.weight.size(), Half::right);
    std::int64_t grown = 0;
    for (const std::int32_t v : breadth_first(graph, seed)) {
      if (2 * grown >= total) break;
      half[v] = Half::left;
      grown += graph.weight[v];
    }
    std::vector<std::int32_t> border;
    for (std::int32_t v = 0; v < graph.size(); ++v) {
      if (half[v] != Half::right) continue;
      for (std::int32_t e = graph.start[v]; e < graph.start[v + 1]; ++e)
        if (index(half[graph.neighbour[e]]) == left) {
          border.push_back(v);
          break;
        }
    }
    for (const std::int32_t v : border) half[v] = Half::separator;
    Division division(graph, half);
    division.refine();
    if (best.empty() || division.cost() < least) {
      least = division.cost();
      best = std::move(half);
    }
  }
  return best;
}

}  // namespace

std::vector<Half> bisect(const Graph& graph) {
  constexpr std::int32_t coarsest = 120;
  if (graph.size() <= coarsest) return divide(graph);
  std::vector<std::int32_t> coarse_of;
  const Graph coarse = coarsen(graph, coarse_of);
  if (20 * coarse.size() > 19 * graph.size()) return divide(graph);  // hardly an edge left to match along
  const std::vector<Half> of_coarse = bisect(coarse);
  std::vector<Half> half(graph.weight.size());
  for (std::int32_t v = 0; v < graph.size(); ++v) half[v] = of_coarse[coarse_of[v]];
  Division(graph, half).refine();
  return half;
}

}  // namespace plica
