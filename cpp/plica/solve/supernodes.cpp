#include "plica/solve/supernodes.hpp"

#include <algorithm>
#include <numeric>

namespace plica {
namespace {

using List = std::vector<std::int32_t>;

List inverse(const Order& order) {
  List position(order.size());
  for (std::size_t k = 0; k < order.size(); ++k) position[order[k]] = static_cast<std::int32_t>(k);
  return position;
}

/// The parent of each column in the elimination tree (Liu 1990), -1 for a root.
List elimination_tree(const NodePattern& graph, const Order& order, const List& position) {
  const auto n = static_cast<std::int32_t>(order.size());
  List parent(order.size(), -1), ancestor(order.size(), -1);
  for (std::int32_t j = 0; j < n; ++j) {
    for (std::int32_t e = graph.row_start[order[j]]; e < graph.row_start[order[j] + 1]; ++e) {
      for (std::int32_t i = position[graph.column[e]]; i < j;) {
        const std::int32_t up = ancestor[i];
        ancestor[i] = j;
        if (up < 0) parent[i] = j;
        if (up < 0 || up == j) break;
        i = up;
      }
    }
  }
  return parent;
}

std::vector<List> children_of(const List& parent) {
  std::vector<List> children(parent.size());
  for (std::size_t i = 0; i < parent.size(); ++i)
    if (parent[i] >= 0) children[parent[i]].push_back(static_cast<std::int32_t>(i));
  return children;
}

/// Children before their parents, each subtree together; entries that are not roots and hang nowhere are left out.
List postorder(const List& roots, const std::vector<List>& children) {
  List result, open(roots.rbegin(), roots.rend());
  std::vector<std::uint8_t> opened(children.size(), 0);
  while (!open.empty()) {
    const std::int32_t node = open.back();
    if (opened[node]) {
      result.push_back(node);
      open.pop_back();
    } else {
      opened[node] = 1;
      open.insert(open.end(), children[node].rbegin(), children[node].rend());
    }
  }
  return result;
}

List roots_of(const List& parent) {
  List roots;
  for (std::size_t i = 0; i < parent.size(); ++i)
    if (parent[i] < 0) roots.push_back(static_cast<std::int32_t>(i));
  return roots;
}

/// A supernode while the tree is still being joined.
struct Part {
  List columns, rows, children;
  std::int32_t parent = -1;
};

/// Runs of columns with the same rows below, of a postordered graph.
std::vector<Part> fundamental(const NodePattern& graph, const Order& order, const List& position,
                              const List& parent) {
  const auto n = static_cast<std::int32_t>(order.size());
  const std::vector<List> children = children_of(parent);
  std::vector<List> below(order.size());
  List mark(order.size(), -1), part_of(order.size());
  std::vector<Part> parts;
  for (std::int32_t j = 0; j < n; ++j) {
    mark[j] = j;
    const auto add = [&](std::int32_t i) {
      if (i > j && mark[i] != j) mark[i] = j, below[j].push_back(i);
    };
    for (std::int32_t e = graph.row_start[order[j]]; e < graph.row_start[order[j] + 1]; ++e)
      add(position[graph.column[e]]);
    bool runs_on = false;  // the column before has these rows and this one
    for (const std::int32_t child : children[j]) {
      for (const std::int32_t i : below[child]) add(i);
      if (child != j - 1) below[child] = {};
    }
    if (!children[j].empty() && children[j].back() == j - 1) {
      runs_on = below[j - 1].size() == below[j].size() + 1;
      below[j - 1] = {};
    }
    if (!runs_on) parts.emplace_back();
    Part& part = parts.back();
    part.columns.push_back(j);
    part.rows = below[j];
    part_of[j] = static_cast<std::int32_t>(parts.size()) - 1;
  }
  for (std::size_t s = 0; s < parts.size(); ++s) {
    const std::int32_t up = parent[parts[s].columns.back()];
    if (up < 0) continue;
    parts[s].parent = part_of[up];
    parts[parts[s].parent].children.push_back(static_cast<std::int32_t>(s));
  }
  return parts;
}

/// What a supernode costs a solve, in floats streamed: its panel twice; the indices of its rows and their vectors
/// twice, estimated as 10; two calls, estimated as 500.
std::ptrdiff_t cost(std::size_t columns, std::size_t rows) {
  const auto w = static_cast<std::ptrdiff_t>(columns), m = static_cast<std::ptrdiff_t>(rows);
  return 2 * panel_floats(w, m) + 10 * m + 500;
}

void amalgamate(std::vector<Part>& parts) {
  for (std::size_t p = 0; p < parts.size(); ++p) {  // children first
    Part& part = parts[p];
    for (;;) {
      std::ptrdiff_t best = 0;
      std::size_t chosen = 0;
      for (std::size_t k = 0; k < part.children.size(); ++k) {
        const Part& child = parts[part.children[k]];
        const std::ptrdiff_t gain = cost(child.columns.size(), child.rows.size()) +
                                    cost(part.columns.size(), part.rows.size()) -
                                    cost(child.columns.size() + part.columns.size(), part.rows.size());
        if (gain > best) best = gain, chosen = k;
      }
      if (best == 0) break;
      Part& child = parts[part.children[chosen]];
      child.columns.insert(child.columns.end(), part.columns.begin(), part.columns.end());
      part.columns = std::move(child.columns);
      for (const std::int32_t grandchild : child.children) parts[grandchild].parent = static_cast<std::int32_t>(p);
      const List grandchildren = std::move(child.children);
      part.children.erase(part.children.begin() + static_cast<std::ptrdiff_t>(chosen));
      part.children.insert(part.children.end(), grandchildren.begin(), grandchildren.end());
      child = {};
    }
  }
}

}  // namespace

std::ptrdiff_t Supernodes::floats() const {
  std::ptrdiff_t sum = 0;
  for (std::int32_t s = 0; s < count(); ++s) sum += panel_floats(columns(s), rows(s));
  return sum;
}

Supernodes supernodes(const NodePattern& graph, const Order& order) {
  Order postordered;
  {
    const List parent = elimination_tree(graph, order, inverse(order));
    for (const std::int32_t k : postorder(roots_of(parent), children_of(parent))) postordered.push_back(order[k]);
  }
  const List position = inverse(postordered);
  std::vector<Part> parts =
      fundamental(graph, postordered, position, elimination_tree(graph, postordered, position));
  amalgamate(parts);

  List roots;
  std::vector<List> children(parts.size());
  for (std::size_t s = 0; s < parts.size(); ++s) {
    if (parts[s].columns.empty()) continue;
    if (parts[s].parent < 0) roots.push_back(static_cast<std::int32_t>(s));
    children[s] = parts[s].children;
  }
  const List sequence = postorder(roots, children);
  Supernodes result;
  List moved(order.size());  // old position to new
  result.first.push_back(0);
  for (const std::int32_t s : sequence) {
    for (const std::int32_t j : parts[s].columns) {
      moved[j] = static_cast<std::int32_t>(result.order.size());
      result.order.push_back(postordered[j]);
      result.supernode_of.push_back(static_cast<std::int32_t>(result.first.size()) - 1);
    }
    result.first.push_back(static_cast<std::int32_t>(result.order.size()));
  }
  result.row_start.push_back(0);
  for (const std::int32_t s : sequence) {
    for (const std::int32_t i : parts[s].rows) result.row.push_back(moved[i]);
    const auto begin = result.row.begin() + result.row_start.back();
    std::sort(begin, result.row.end());
    result.parent.push_back(begin == result.row.end() ? -1 : result.supernode_of[*begin]);
    result.row_start.push_back(static_cast<std::ptrdiff_t>(result.row.size()));
  }
  result.children = children_of(result.parent);
  result.place.resize(result.row.size());
  for (std::int32_t s = 0; s < result.count(); ++s) {
    const std::int32_t p = result.parent[s];
    if (p < 0) continue;
    std::ptrdiff_t at = result.row_start[p];
    for (std::ptrdiff_t k = result.row_start[s]; k < result.row_start[s + 1]; ++k) {
      const std::int32_t i = result.row[k];
      if (i < result.first[p + 1]) {
        result.place[k] = i - result.first[p];
      } else {
        while (result.row[at] != i) ++at;
        result.place[k] = result.columns(p) + static_cast<std::int32_t>(at - result.row_start[p]);
      }
    }
  }
  return result;
}

}  // namespace plica
