#include "plica/estimation/sweep.hpp"

#include <algorithm>
#include <cmath>
#include <variant>

#include "plica/core/error.hpp"
#include "plica/core/require.hpp"
#include "plica/core/threads.hpp"
#include "plica/estimation/lane_solver.hpp"

namespace plica::estimation {
namespace {

constexpr int pack = BlockMatrix::pack;
using Packed = std::vector<double>;  // [lanes * unknown + lane]

/// The finished step of the undifferentiated columns, `pack` of them at a time: what the derivatives are driven
/// by.
struct Base {
  Packed U, V;  // (1+al) u1 - al u0 and likewise v1
};

/// Motion of 8 or 16 columns that share each pass over the factor; column `first` is lane 0.
template <int lanes_>
struct Columns {
  static constexpr int lanes = lanes_;
  Columns(std::ptrdiff_t first_column, std::size_t unknowns)
      : first(first_column), u(lanes * unknowns, 0.0), v(u), a(u), U(u), V(u), source(u) {
    f.r = f.d = u;
  }
  std::ptrdiff_t first;
  Packed u, v, a;
  Packed U, V;    // (1+al) u1 - al u0 of the predictors, likewise v1
  Packed source;  // force of the step, N
  LaneForce<lanes> f;
};
using Group = std::variant<Columns<8>, Columns<16>>;

struct Marching {
  const LinearMotion& m;
  const LaneSolver& solver;

  /// One step under c.source; leaves U and V of the finished step of column i < q in base[i / pack].
  template <typename C>
  void advance(C& c, std::ptrdiff_t step, std::ptrdiff_t q, std::vector<Base>& base) const {
    const double h = m.step, al = m.alpha;
    const double ua = h * h * (0.5 - m.beta), va = (1 - m.gamma) * h;
    for_slices(length(c.u), [&](std::ptrdiff_t at, std::ptrdiff_t count) {
      for (auto i = static_cast<std::size_t>(at); i < static_cast<std::size_t>(at + count); ++i) {
        const double u0 = c.u[i], v0 = c.v[i], a0 = c.a[i];
        c.u[i] = u0 + h * v0 + ua * a0;
        c.v[i] = v0 + va * a0;
        c.U[i] = (1 + al) * c.u[i] - al * u0;
        c.V[i] = (1 + al) * c.v[i] - al * v0;
      }
    });
    solver.force(c.U, c.V, c.source, c.f);
    solver.solve(c.f, c.a, step);
    const double du = m.beta * h * h, dv = m.gamma * h;
    const std::ptrdiff_t own = std::clamp<std::ptrdiff_t>(q - c.first, 0, C::lanes);
    for_slices(length(c.u) / C::lanes, [&](std::ptrdiff_t at, std::ptrdiff_t count) {
      for (auto k = static_cast<std::size_t>(at); k < static_cast<std::size_t>(at + count); ++k) {
        for (std::size_t i = C::lanes * k; i < C::lanes * (k + 1); ++i) {
          c.u[i] += du * c.a[i];
          c.v[i] += dv * c.a[i];
        }
        for (std::ptrdiff_t lane = 0; lane < own; ++lane) {
          const std::ptrdiff_t column = c.first + lane;
          const std::size_t from = C::lanes * k + static_cast<std::size_t>(lane),
                            to = pack * k + static_cast<std::size_t>(column % pack);
          Base& target = base[static_cast<std::size_t>(column / pack)];
          target.U[to] = c.U[from] + (1 + al) * du * c.a[from];
          target.V[to] = c.V[from] + (1 + al) * dv * c.a[from];
        }
      }
    });
  }

  static std::ptrdiff_t length(const Packed& x) { return static_cast<std::ptrdiff_t>(x.size()); }
};

/// All columns: the q of the patterns, then those of the derivatives, which follow one step behind.
class Columnwise {
 public:
  Columnwise(std::ptrdiff_t q, std::ptrdiff_t width, std::size_t unknowns)
      : q_(q), width_(width), unknowns_(unknowns) {
    std::ptrdiff_t first = 0;
    for (; width - first > 8; first += 16) groups_.emplace_back(std::in_place_type<Columns<16>>, first, unknowns);
    if (width > first) groups_.emplace_back(std::in_place_type<Columns<8>>, first, unknowns);
    base_.resize(static_cast<std::size_t>((q + pack - 1) / pack));
    for (Base& base : base_) base.U = base.V = Packed(pack * unknowns, 0.0);
  }

  /// The patterns push in the first step alone.
  void push(const RowMatrix& patterns) {
    for (std::ptrdiff_t i = 0; i < q_; ++i)
      write_source(i, 0, patterns.rows(), [&](std::ptrdiff_t k) { return patterns(k, i); });
  }
  void release() {
    for (std::ptrdiff_t i = 0; i < q_; ++i)
      write_source(i, 0, static_cast<std::ptrdiff_t>(unknowns_), [](std::ptrdiff_t) { return 0.0; });
  }

  /// source = -(dK U + dC V) of the finished step, one direction after another.
  void take_sources(const std::vector<Direction>& directions) {
    elastic_.resize(static_cast<std::size_t>(pack) * unknowns_);
    viscous_.resize(elastic_.size());
    for_chunks(static_cast<std::ptrdiff_t>(unknowns_) / 3, BlockMatrix::chunk_rows,
               [&](std::ptrdiff_t begin, std::ptrdiff_t end, std::ptrdiff_t) {
                 for (std::size_t j = 0; j < directions.size(); ++j)
                   for (std::size_t p = 0; p < base_.size(); ++p) {
                     const std::optional<BlockMatrix>&dK = directions[j].stiffness, &dC = directions[j].viscosity;
                     if (dK) dK->multiply_rows_packed(begin, end, base_[p].U, elastic_);
                     if (dC) dC->multiply_rows_packed(begin, end, base_[p].V, viscous_);
                     const auto first = static_cast<std::ptrdiff_t>(p) * pack;
                     for (std::ptrdiff_t i = first; i < std::min(q_, first + pack); ++i)
                       write_source((1 + static_cast<std::ptrdiff_t>(j)) * q_ + i, 3 * begin, 3 * (end - begin),
                                    [&](std::ptrdiff_t k) {
                                      const auto at = static_cast<std::size_t>(pack * k + i % pack);
                                      return -(dK ? elastic_[at] : 0.0) - (dC ? viscous_[at] : 0.0);
                                    });
                   }
               });
  }

  void advance(const Marching& marching, std::ptrdiff_t step) {
    const auto one = [&](Group& group) {
      std::visit([&](auto& columns) { marching.advance(columns, step, q_, base_); }, group);
    };
    if (groups_.size() == 1) return one(groups_.front());  // the kernels inside take the threads
    std::vector<std::string> failed(groups_.size());       // work must not throw
    for_chunks(static_cast<std::ptrdiff_t>(groups_.size()), 1,
               [&](std::ptrdiff_t k, std::ptrdiff_t, std::ptrdiff_t) {
                 try {
                   one(groups_[static_cast<std::size_t>(k)]);
                 } catch (const std::exception& error) {
                   failed[static_cast<std::size_t>(k)] = error.what();
                 }
               });
    for (const std::string& text : failed)
      if (!text.empty()) throw SolveFailed(text);
  }

  /// Displacements of the columns [begin, end), out[o * width + column].
  void record(const Indices& observed, std::ptrdiff_t begin, std::ptrdiff_t end, double* out) const {
    for (const Group& group : groups_)
      std::visit(
          [&](const auto& c) {
            const std::ptrdiff_t from = std::max(begin, c.first), to = std::min(end, c.first + c.lanes);
            for (std::ptrdiff_t o = 0; o < observed.size(); ++o)
              for (std::ptrdiff_t column = from; column < to; ++column)
                out[o * width_ + column] = c.u[static_cast<std::size_t>(
                    c.lanes * static_cast<std::ptrdiff_t>(observed[o]) + column - c.first)];
          },
          group);
  }

 private:
  /// value(k) into the unknowns k of [from, from + count).
  template <typename Value>
  void write_source(std::ptrdiff_t column, std::ptrdiff_t from, std::ptrdiff_t count, const Value& value) {
    std::visit(
        [&](auto& c) {
          double* lane = c.source.data() + (column - c.first);
          for (std::ptrdiff_t k = from; k < from + count; ++k) lane[c.lanes * k] = value(k);
        },
        groups_[static_cast<std::size_t>(column / 16)]);
  }

  std::ptrdiff_t q_, width_;
  std::size_t unknowns_;
  std::vector<Group> groups_;
  std::vector<Base> base_;
  Packed elastic_, viscous_;  // products of one direction, [pack * unknown + lane]
};

/// The step's matrix is summed entry by entry.
void require_pattern_of(const BlockMatrix& K, const std::string& name, const NodePattern& pattern) {
  const NodePattern& wanted = *K.pattern();
  if (&pattern != &wanted && (pattern.row_start != wanted.row_start || pattern.column != wanted.column))
    throw InvalidInput("impulse_responses: the pattern of " + name + " is not that of K; must be the same.");
}

void require_sizes(const LinearMotion& motion, const RowMatrix& patterns, const std::vector<Direction>& directions,
                   const Indices& observed, std::ptrdiff_t steps, double tolerance) {
  const std::ptrdiff_t unknowns = motion.K.rows();
  const std::string where = "impulse_responses";
  if (patterns.rows() != unknowns)
    throw InvalidInput(where, "rows of patterns", static_cast<double>(patterns.rows()), "",
                       "the number of unknowns, " + number_text(static_cast<double>(unknowns)));
  require_pattern_of(motion.K, "M", *motion.M.pattern());
  if (motion.C) require_pattern_of(motion.K, "C", *motion.C->pattern());
  require_size(where.c_str(), "the supports", motion.supports.size(), unknowns);
  for (const Direction& direction : directions)
    for (const std::optional<BlockMatrix>* part : {&direction.stiffness, &direction.viscosity})
      if (*part) require_size(where.c_str(), "the rows of a direction", (*part)->rows(), unknowns);
  if (patterns.cols() < 1) throw InvalidInput(where, "columns of patterns", 0, "", ">= 1");
  if (steps < 1) throw InvalidInput(where, "steps", static_cast<double>(steps), "", ">= 1");
  if (!(tolerance > 0 && tolerance < 1)) throw InvalidInput(where, "tolerance", tolerance, "", "in (0, 1)");
  if (!(motion.step > 0)) throw InvalidInput(where, "step", motion.step, "s", "> 0");
  if (!patterns.allFinite()) throw InvalidInput(where + ": patterns must be finite.");
  for (const auto o : observed)
    if (o < 0 || o >= unknowns)
      throw InvalidInput(where, "observed unknown", o, "",
                         "in [0, " + number_text(static_cast<double>(unknowns)) + ")");
}

BlockMatrix step_matrix(const LinearMotion& m) {
  const double c = (1 + m.alpha) * m.gamma * m.step, k = (1 + m.alpha) * m.beta * m.step * m.step;
  BlockMatrix A(m.K.pattern());
  for (std::size_t i = 0; i < A.values().size(); ++i) {
    A.values()[i] = k * m.K.values()[i];
    if (m.C) A.values()[i] += c * m.C->values()[i];
  }
  for (std::size_t e = 0; e < m.M.values().size(); ++e)
    for (int d = 0; d < 3; ++d) A.values()[9 * e + 4 * static_cast<std::size_t>(d)] += m.M.values()[e];
  m.supports.constrain(A);
  return A;
}

}  // namespace

FactorPlan sweep_plan(const Pattern& pattern, const Supports& supports) {
  BlockMatrix full(pattern);
  std::fill(full.values().begin(), full.values().end(), 1.0);
  supports.constrain(full);
  return FactorPlan(full);
}

BlockMatrix without_zero_blocks(const BlockMatrix& A) {
  const NodePattern& all = *A.pattern();
  auto kept = std::make_shared<NodePattern>();
  kept->row_start.push_back(0);
  std::vector<double> values;
  for (std::int32_t row = 0; row < all.rows(); ++row) {
    for (std::int32_t e = all.row_start[row]; e < all.row_start[row + 1]; ++e) {
      const double* block = A.block(e);
      const bool zero = std::all_of(block, block + 9, [](double x) { return x == 0.0; });
      if (zero && all.column[e] != row) continue;
      kept->column.push_back(all.column[e]);
      values.insert(values.end(), block, block + 9);
    }
    kept->row_start.push_back(static_cast<std::int32_t>(kept->column.size()));
  }
  BlockMatrix short_one(kept);
  short_one.values() = std::move(values);
  return short_one;
}

RowMatrix impulse_responses(const LinearMotion& motion, const RowMatrix& patterns,
                            const std::vector<Direction>& directions, const Indices& observed,
                            std::ptrdiff_t steps, double tolerance, const FactorPlan* plan) {
  require_sizes(motion, patterns, directions, observed, steps, tolerance);
  const std::ptrdiff_t q = patterns.cols(), width = (1 + static_cast<std::ptrdiff_t>(directions.size())) * q;
  const std::ptrdiff_t behind = directions.empty() ? 0 : 1;
  std::vector<double> free(static_cast<std::size_t>(motion.K.rows()));
  for (std::size_t k = 0; k < free.size(); ++k)
    free[k] = motion.supports.fixed(static_cast<std::ptrdiff_t>(k)) ? 0.0 : 1.0;
  const BlockMatrix A = step_matrix(motion);
  const LaneSolver solver(motion.K, motion.C, A, plan ? *plan : FactorPlan(A), free, tolerance);
  const Marching marching{motion, solver};
  Columnwise columns(q, width, free.size());
  RowMatrix out(steps, observed.size() * width);
  for (std::ptrdiff_t s = 0; s < steps + behind; ++s) {
    if (s == 0) columns.push(patterns);
    if (s == 1) columns.release();
    if (s > 0) columns.take_sources(directions);
    columns.advance(marching, s);
    if (s < steps) columns.record(observed, 0, q, out.row(s).data());
    if (behind && s > 0) columns.record(observed, q, width, out.row(s - 1).data());
  }
  return out;
}

}  // namespace plica::estimation
