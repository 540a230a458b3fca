#include "plica/solve/triangular_factor.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <mutex>

#include "plica/core/error.hpp"
#include "plica/core/require.hpp"
#include "plica/solve/front.hpp"
#include "plica/solve/panel_kernels.hpp"

namespace plica {
namespace {

/// A pivot below this share of its diagonal entry has lost all but four digits to cancellation.
constexpr double smallest_pivot = 1e-12;

[[noreturn]] void refuse(const std::string& what) {
  throw SolveFailed("Cholesky: matrix is not positive definite: " + what +
                    ". A body without support, or an inverted element?");
}

/// Scalar position of a node of a front whose columns are padded.
std::ptrdiff_t scalar(std::ptrdiff_t place, std::ptrdiff_t columns) {
  return place < columns ? 3 * place : padded(columns) + 3 * (place - columns);
}

}  // namespace

FactorPlan::FactorPlan(const BlockMatrix& A) {
  const NodePattern& p = *A.pattern();
  const auto n = static_cast<std::int32_t>(p.rows());
  std::vector<std::int32_t> number_of(static_cast<std::size_t>(n), -1), coupled;
  const auto couples = [&](std::int32_t i, std::int32_t e) {
    return p.column[e] != i && std::any_of(A.block(e), A.block(e) + 9, [](double v) { return v != 0.0; });
  };
  for (std::int32_t i = 0; i < n; ++i) {
    bool any = false;
    for (std::int32_t e = p.row_start[i]; e < p.row_start[i + 1]; ++e) {
      const std::int32_t back = p.find(p.column[e], i);
      if (back < 0)
        throw InvalidInput("Cholesky", "A(" + number_text(i) + ", " + number_text(p.column[e]) + ")", 1, "",
                           "in a symmetric pattern");
      any = any || couples(i, e) || couples(p.column[e], back);
    }
    if (any) number_of[i] = static_cast<std::int32_t>(coupled.size());
    (any ? coupled : alone).push_back(i);
  }
  if (coupled.empty()) {
    tree = supernodes({{0}, {}}, {});
    return;
  }
  NodePattern graph;
  graph.row_start.push_back(0);
  for (const std::int32_t i : coupled) {
    for (std::int32_t e = p.row_start[i]; e < p.row_start[i + 1]; ++e) {
      const std::int32_t j = p.column[e];
      if (j == i || couples(i, e) || couples(j, p.find(j, i))) graph.column.push_back(number_of[j]);
    }
    graph.row_start.push_back(static_cast<std::int32_t>(graph.column.size()));
  }
  tree = supernodes(graph, nested_dissection(graph));
  Supernodes other = supernodes(graph, minimum_degree(graph));
  if (other.floats() < tree.floats()) tree = std::move(other);
  for (std::int32_t& node : tree.order) node = coupled[node];
}

/// The fronts on their way up the tree.
struct TriangularFactor::Fronts {
  Fronts(const BlockMatrix& A, TriangularFactor& factor)
      : A_(A),
        factor_(factor),
        tree_(factor.plan_.tree),
        updates_(static_cast<std::size_t>(tree_.count())),
        position_(static_cast<std::size_t>(A.rows() / 3), -1) {
    for (std::size_t k = 0; k < tree_.order.size(); ++k) position_[tree_.order[k]] = static_cast<std::int32_t>(k);
  }

  void eliminate(std::int32_t s) {
    const std::ptrdiff_t columns = tree_.columns(s), rows = tree_.rows(s), pivots = 3 * columns;
    Front front(3 * (columns + rows));
    assemble(s, front);
    for (const std::int32_t child : tree_.children[s]) {
      add_update(child, front);
      updates_[child] = {};
    }
    const std::ptrdiff_t failed = front.eliminate(pivots, smallest_pivot);
    if (failed >= 0) {
      const std::int32_t node = tree_.order[tree_.first[s] + failed / 3];
      const std::lock_guard<std::mutex> lock(mutex_);
      if (failed_node_ < 0 || s < failed_front_) {  // a child's failure spoils its parents
        failed_front_ = s;
        failed_node_ = node;
        failed_component_ = static_cast<int>(failed % 3);
        failed_pivot_ = front.at(failed, failed);
      }
    }
    store(s, front);
    std::vector<double>& update = updates_[s];
    update.resize(static_cast<std::size_t>(9 * rows * rows));
    for (std::ptrdiff_t j = 0; j < 3 * rows; ++j)
      std::copy_n(front.column(pivots + j) + pivots + j, 3 * rows - j, update.data() + j * 3 * rows + j);
  }

  void check() const {
    if (failed_node_ < 0) return;
    refuse("pivot of node " + number_text(failed_node_) + " along " + "xyz"[failed_component_] + " = " +
           number_text(failed_pivot_) + " of its diagonal entry; must be > " + number_text(smallest_pivot));
  }

 private:
  /// The entries of S A S in the front's columns.
  void assemble(std::int32_t s, Front& front) const {
    const NodePattern& p = *A_.pattern();
    const auto rows_begin = tree_.row.begin() + tree_.row_start[s],
               rows_end = tree_.row.begin() + tree_.row_start[s + 1];
    for (std::int32_t k = tree_.first[s]; k < tree_.first[s + 1]; ++k) {
      const std::int32_t node = tree_.order[k];
      const std::ptrdiff_t column = 3 * (k - tree_.first[s]);
      for (std::int32_t e = p.row_start[node]; e < p.row_start[node + 1]; ++e) {
        const std::int32_t other = p.column[e], q = position_[other];
        if (q < k) continue;  // eliminated before, or a zero block to a node alone
        std::ptrdiff_t row;
        if (q < tree_.first[s + 1]) {
          row = 3 * (q - tree_.first[s]);
        } else {
          const auto at = std::lower_bound(rows_begin, rows_end, q);
          if (at == rows_end || *at != q) continue;  // a zero block
          row = 3 * (tree_.columns(s) + (at - rows_begin));
        }
        const double* block = A_.block(e);  // of row node and column other: that of the lower triangle transposed
        for (int i = 0; i < 3; ++i)
          for (int j = 0; j < 3; ++j)
            front.at(row + i, column + j) = block[3 * j + i] *
                                            factor_.scale_[3 * static_cast<std::size_t>(other) + i] *
                                            factor_.scale_[3 * static_cast<std::size_t>(node) + j];
      }
    }
  }

  void add_update(std::int32_t child, Front& front) const {
    const std::ptrdiff_t rows = tree_.rows(child);
    const std::int32_t* place = tree_.place.data() + tree_.row_start[child];
    const double* update = updates_[child].data();
    for (std::ptrdiff_t j = 0; j < 3 * rows; ++j) {
      double* out = front.column(3 * place[j / 3] + j % 3);
      const double* in = update + j * 3 * rows;
      for (std::ptrdiff_t i = j; i < 3 * rows; ++i) out[3 * place[i / 3] + i % 3] += in[i];
    }
  }

  /// The tiles of a supernode, the triangles on the diagonal inverted.
  void store(std::int32_t s, Front& front) const {
    const std::ptrdiff_t columns = tree_.columns(s), rows = tree_.rows(s), pivots = 3 * columns;
    const std::ptrdiff_t groups = padded(columns) / tile, tiles = groups + padded(rows) / tile;
    float* out = factor_.values_.data() + factor_.panel_[s];
    const auto front_row = [&](std::ptrdiff_t stored) {  // -1: padding
      if (stored < padded(columns)) return stored < pivots ? stored : -1;
      const std::ptrdiff_t below = stored - padded(columns);
      return below < 3 * rows ? pivots + below : -1;
    };
    for (std::ptrdiff_t g = 0; g < groups; ++g) {
      const std::ptrdiff_t from = tile * g, count = std::min(tile, pivots - from);
      for (std::ptrdiff_t j = 0; j < count; ++j) {  // inverse of the triangle, column by column
        double x[tile] = {};
        for (std::ptrdiff_t i = j; i < count; ++i) {
          double rest = i == j ? 1.0 : 0.0;
          for (std::ptrdiff_t k = j; k < i; ++k) rest -= front.at(from + i, from + k) * x[k];
          x[i] = rest / front.at(from + i, from + i);
          out[tile * j + i] = static_cast<float>(x[i]);
        }
      }
      for (std::ptrdiff_t t = g + 1; t < tiles; ++t) {
        out += tile * tile;
        for (std::ptrdiff_t i = 0; i < tile; ++i) {
          const std::ptrdiff_t row = front_row(tile * t + i);
          if (row < 0) continue;
          for (std::ptrdiff_t j = 0; j < count; ++j)
            out[tile * j + i] = static_cast<float>(front.at(row, from + j));
        }
      }
      out += tile * tile;
    }
  }

  const BlockMatrix& A_;
  TriangularFactor& factor_;
  const Supernodes& tree_;
  std::vector<std::vector<double>> updates_;  // Schur complements that wait for their parent
  std::vector<std::int32_t> position_;        // of each node, -1 if alone
  std::mutex mutex_;                          // guards what failed
  std::int32_t failed_front_ = -1;
  std::int32_t failed_node_ = -1;
  int failed_component_ = 0;
  double failed_pivot_ = 0.0;
};

TriangularFactor::TriangularFactor(const BlockMatrix& A, FactorPlan plan)
    : plan_(std::move(plan)), subtrees_(plan_.tree) {
  const NodePattern& p = *A.pattern();
  const Supernodes& tree = plan_.tree;
  require_size("TriangularFactor", "the plan's nodes",
               static_cast<std::ptrdiff_t>(tree.supernode_of.size() + plan_.alone.size()), p.rows());
  scale_.resize(static_cast<std::size_t>(A.rows()));
  for (std::int32_t i = 0; i < p.rows(); ++i) {
    const double* block = A.block(p.find(i, i));
    for (int c = 0; c < 3; ++c) {
      if (!(block[4 * c] > 0.0 && std::isfinite(block[4 * c])))
        refuse("diagonal entry of node " + number_text(i) + " along " + "xyz"[c] + " = " +
               number_text(block[4 * c]) + "; must be > 0");
      scale_[3 * static_cast<std::size_t>(i) + c] = 1.0 / std::sqrt(block[4 * c]);
    }
  }
  for (const std::int32_t i : plan_.alone) {
    using Block = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
    const Block block = Eigen::Map<const Block>(A.block(p.find(i, i)));
    if (!(block.topLeftCorner<2, 2>().determinant() > 0.0 && block.determinant() > 0.0))
      refuse("diagonal block of node " + number_text(i) + " has determinant " + number_text(block.determinant()));
    const Block inverse = block.inverse();
    alone_inverse_.insert(alone_inverse_.end(), inverse.data(), inverse.data() + 9);
  }
  std::ptrdiff_t floats = 0;
  front_.push_back(0);
  for (std::int32_t s = 0; s < tree.count(); ++s) {
    panel_.push_back(floats);
    floats += panel_floats(tree.columns(s), tree.rows(s));
    front_.push_back(front_.back() + padded(tree.columns(s)) + padded(tree.rows(s)));
  }
  for (std::int32_t s = 0; s < tree.count(); ++s) {
    for (std::ptrdiff_t k = tree.row_start[s]; k < tree.row_start[s + 1]; ++k) {
      const std::int32_t column_in = tree.supernode_of[tree.row[k]], up = tree.parent[s];
      as_column_.push_back(front_[column_in] + 3 * (tree.row[k] - tree.first[column_in]));
      in_parent_.push_back(front_[up] + scalar(tree.place[k], tree.columns(up)));
    }
  }
  values_ = Eigen::VectorXf::Zero(floats);
  Fronts fronts(A, *this);
  subtrees_.upward([&](std::int32_t s) { fronts.eliminate(s); });
  fronts.check();
}

void TriangularFactor::solve(const Vector& b, Vector& x) const {
  require_size("TriangularFactor", "b", b.size(), static_cast<std::ptrdiff_t>(scale_.size()));
  x.resize(b.size());
  apply<1>(b.data(), x.data());
}

void TriangularFactor::solve_packed(const double* b, double* x) const { apply<pack>(b, x); }

void TriangularFactor::solve_wide(const double* b, double* x) const { apply<wide>(b, x); }

template <int lanes>
void TriangularFactor::apply(const double* b, double* x) const {
  const Supernodes& tree = plan_.tree;
  const PanelKernels& kernels = panel_kernels();
  const auto forward = lanes == 1      ? kernels.forward
                       : lanes == pack ? kernels.forward_packed
                                       : kernels.forward_wide;
  const auto backward = lanes == 1      ? kernels.backward
                        : lanes == pack ? kernels.backward_packed
                                        : kernels.backward_wide;
  // Each right-hand side is brought to the size of one, so that single precision neither overflows nor vanishes.
  const auto unknowns = static_cast<std::ptrdiff_t>(scale_.size());
  double largest[lanes] = {}, shrink[lanes], grow[lanes];
  for (std::ptrdiff_t i = 0; i < unknowns; ++i)
    for (int v = 0; v < lanes; ++v) largest[v] = std::max(largest[v], std::abs(b[lanes * i + v]) * scale_[i]);
  for (int v = 0; v < lanes; ++v) {
    grow[v] = largest[v] > 0.0 ? largest[v] : 1.0;
    shrink[v] = 1.0 / grow[v];
  }
  static thread_local Eigen::VectorXf kept;  // a new one a call would be cleared by the kernel page by page
  if (kept.size() < lanes * front_.back()) kept.resize(lanes * front_.back());
  float* const f = kept.data();
  subtrees_.upward([&](std::int32_t s) {
    const std::ptrdiff_t columns = tree.columns(s), rows = tree.rows(s);
    float* own = f + lanes * front_[s];
    std::fill_n(own, lanes * (front_[s + 1] - front_[s]), 0.0f);
    for (const std::int32_t child : tree.children[s]) {  // taken in order, whoever computed it
      const float* below = f + lanes * (front_[child] + padded(tree.columns(child)));
      for (std::ptrdiff_t k = tree.row_start[child]; k < tree.row_start[child + 1]; ++k, below += 3 * lanes) {
        float* out = f + lanes * in_parent_[k];
        for (int c = 0; c < 3 * lanes; ++c) out[c] += below[c];
      }
    }
    for (std::ptrdiff_t k = 0; k < columns; ++k) {
      const std::ptrdiff_t at = 3 * static_cast<std::ptrdiff_t>(tree.order[tree.first[s] + k]);
      for (int c = 0; c < 3; ++c)
        for (int v = 0; v < lanes; ++v)
          own[lanes * (3 * k + c) + v] +=
              static_cast<float>(b[lanes * (at + c) + v] * (scale_[at + c] * shrink[v]));
    }
    const std::ptrdiff_t groups = padded(columns) / tile, tiles = groups + padded(rows) / tile;
    forward(values_.data() + panel_[s], groups, tiles, own);
  });
  subtrees_.downward([&](std::int32_t s) {
    const std::ptrdiff_t columns = tree.columns(s), rows = tree.rows(s);
    float* own = f + lanes * front_[s];
    float* below = own + lanes * padded(columns);
    for (std::ptrdiff_t k = tree.row_start[s]; k < tree.row_start[s + 1]; ++k, below += 3 * lanes)
      std::copy_n(f + lanes * as_column_[k], 3 * lanes, below);
    const std::ptrdiff_t groups = padded(columns) / tile, tiles = groups + padded(rows) / tile;
    backward(values_.data() + panel_[s], groups, tiles, own);
    for (std::ptrdiff_t k = 0; k < columns; ++k) {
      const std::ptrdiff_t at = 3 * static_cast<std::ptrdiff_t>(tree.order[tree.first[s] + k]);
      for (int c = 0; c < 3; ++c)
        for (int v = 0; v < lanes; ++v)
          x[lanes * (at + c) + v] = own[lanes * (3 * k + c) + v] * (scale_[at + c] * grow[v]);
    }
  });
  for (std::size_t k = 0; k < plan_.alone.size(); ++k) {
    const double* m = alone_inverse_.data() + 9 * k;
    const std::ptrdiff_t at = 3 * static_cast<std::ptrdiff_t>(plan_.alone[k]);
    for (int c = 0; c < 3; ++c)
      for (int v = 0; v < lanes; ++v)
        x[lanes * (at + c) + v] = m[3 * c] * b[lanes * at + v] + m[3 * c + 1] * b[lanes * (at + 1) + v] +
                                  m[3 * c + 2] * b[lanes * (at + 2) + v];
  }
}

}  // namespace plica
