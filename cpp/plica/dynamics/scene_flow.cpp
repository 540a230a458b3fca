#include "plica/dynamics/scene_flow.hpp"

namespace plica {

void SceneFlow::fold_patterns() {
  const LoadPatterns& patterns = airflow_.load_patterns();
  const Indices& nodes = airflow_.nodes();
  if (!images_) {
    own_nodes_ = nodes;
    own_ = patterns;
    return;
  }
  const Indices part = images_->nodes_of(nodes);
  own_nodes_ = images_->nodes()(part);
  std::vector<std::int32_t> place(static_cast<std::size_t>(images_->nodes().size()), -1);
  for (std::int32_t i = 0; i < part.size(); ++i) place[static_cast<std::size_t>(part[i])] = i;
  own_ = {
      {3 * part.size(), patterns.sections.cols()}, Vector::Zero(3 * part.size()), Vector::Zero(3 * part.size())};
  std::vector<Eigen::Triplet<double>> entries;
  for (std::ptrdiff_t row = 0; row < patterns.sections.rows(); ++row) {
    const std::int32_t node = nodes[row / 3];
    const auto own = static_cast<int>(3 * place[static_cast<std::size_t>(images_->node_of(node))] + row % 3);
    const double sign = images_->sign(node)[row % 3];
    own_.below[own] += sign * patterns.below[row];
    own_.above[own] += sign * patterns.above[row];
    for (Eigen::SparseMatrix<double, Eigen::RowMajor>::InnerIterator entry(patterns.sections, row); entry; ++entry)
      entries.emplace_back(own, static_cast<int>(entry.col()), sign * entry.value());
  }
  own_.sections.setFromTriplets(entries.begin(), entries.end());
}

}  // namespace plica
