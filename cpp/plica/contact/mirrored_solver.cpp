#include <algorithm>
#include <cmath>
#include <map>

#include "plica/contact/force_solver.hpp"

namespace plica {

namespace {

using NodeVectors = std::vector<NodeVector>;

/// S^T of a row's vectors, one a node; the first node stays the first.
NodeVectors folded(const NodeVectors& whole, const MirrorImages& images) {
  std::map<std::int32_t, Vector3> sums;
  for (const auto& [node, vector] : whole)
    sums.try_emplace(images.node_of(node), Vector3::Zero()).first->second +=
        images.sign(node).cwiseProduct(vector);
  NodeVectors part;
  if (whole.empty()) return part;
  const auto first = sums.find(images.node_of(whole.front().node));
  part.push_back({first->first, first->second});
  sums.erase(first);
  for (const auto& [node, vector] : sums) part.push_back({node, vector});
  return part;
}

bool alike(const NodeVectors& a, const NodeVectors& b) {
  return a.size() == b.size() && std::equal(a.begin(), a.end(), b.begin(), [](const auto& s, const auto& t) {
           constexpr double round_off = 1e-9;  // of vectors of length 1
           return s.node == t.node && (s.vector - t.vector).cwiseAbs().maxCoeff() <= round_off;
         });
}

/// Rows on all nodes, for a solver on the nodes of the part that is solved for. A constraint and its mirror images
/// are the same row there, so of these one is solved for: m of them push m times as much and their gap is one,
/// which keeps its symmetry as sqrt(m) of both.
class MirroredSolver final : public ForceSolver {
 public:
  MirroredSolver(std::unique_ptr<ForceSolver> part, const MirrorImages& images, const Indices& nodes)
      : part_(std::move(part)),
        images_(images),
        nodes_(nodes),
        rest_(Points::Zero(images.nodes().size(), 3)),
        shift_(rest_) {}

  Complementarity solve(const std::vector<Row>& rows, double scale, std::vector<char> guess, double gap_tolerance,
                        int most_pivots) override {
    const std::vector<Row> part = folded_rows(rows);
    std::vector<Row> apart;                            // one of each group
    std::vector<char> apart_guess;                     // closed where one of its group is
    std::vector<double> size;                          // of its group
    std::vector<std::size_t> group(part.size());       // of each row
    std::multimap<std::int32_t, std::size_t> by_node;  // groups, by the node that their rows push first
    for (std::size_t i = 0; i < part.size(); ++i) {
      const std::int32_t node = part[i].push.front().node;
      const auto [begin, end] = by_node.equal_range(node);
      const auto known = std::find_if(begin, end, [&](const auto& entry) {
        const Row& other = apart[entry.second];
        return std::abs(part[i].free - other.free) <= 1e-3 * gap_tolerance &&
               part[i].compliance == other.compliance && alike(part[i].push, other.push) &&
               alike(part[i].gap, other.gap);
      });
      group[i] = known == end ? apart.size() : known->second;
      if (known != end) {
        size[group[i]] += 1;
        apart_guess[group[i]] = apart_guess[group[i]] || guess[i];
        continue;
      }
      by_node.emplace(node, apart.size());
      apart.push_back(part[i]);
      apart_guess.push_back(guess[i]);
      size.push_back(1);
    }
    for (std::size_t g = 0; g < apart.size(); ++g) {
      const double root = std::sqrt(size[g]);
      for (NodeVectors* side : {&apart[g].push, &apart[g].gap})
        for (auto& [node, vector] : *side) vector *= root;
      apart[g].free *= root;
    }
    const Complementarity found = part_->solve(apart, scale, std::move(apart_guess), gap_tolerance, most_pivots);
    Complementarity all{Vector(static_cast<std::ptrdiff_t>(rows.size())), std::vector<char>(rows.size()),
                        found.pivots, found.converged};
    for (std::size_t i = 0; i < rows.size(); ++i) {
      all.force[static_cast<std::ptrdiff_t>(i)] =
          found.force[static_cast<std::ptrdiff_t>(group[i])] / std::sqrt(size[group[i]]);
      all.active[i] = found.active[group[i]];
    }
    return all;
  }

  Eigen::MatrixXd compliance(const std::vector<Row>& rows, double scale) override {
    return part_->compliance(folded_rows(rows), scale);
  }

  void move(const std::vector<Row>& rows, const Vector& force, double scale, const Points& x_free,
            Points& x) override {
    part_->move(folded_rows(rows), force, scale, rest_, shift_);
    for (const std::int32_t node : nodes_)
      x.row(node) =
          x_free.row(node) + images_.sign(node).transpose().cwiseProduct(shift_.row(images_.node_of(node)));
  }

  void add_response(const Vector& force, Vector& a) const override { part_->add_response(force, a); }
  void forget() override { part_->forget(); }

 private:
  std::vector<Row> folded_rows(const std::vector<Row>& rows) const {
    std::vector<Row> part;
    part.reserve(rows.size());
    for (const Row& row : rows)
      part.push_back({folded(row.push, images_), folded(row.gap, images_), row.free, row.compliance});
    return part;
  }

  std::unique_ptr<ForceSolver> part_;
  const MirrorImages& images_;
  Indices nodes_;
  Points rest_, shift_;  // (p, 3) m, of the part's nodes
};

}  // namespace

std::unique_ptr<ForceSolver> mirrored_solver(std::unique_ptr<ForceSolver> part, const MirrorImages& images,
                                             const Indices& nodes) {
  return std::make_unique<MirroredSolver>(std::move(part), images, nodes);
}

}  // namespace plica
