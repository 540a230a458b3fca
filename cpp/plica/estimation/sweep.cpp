#include "plica/estimation/sweep.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "plica/core/error.hpp"
#include "plica/core/threads.hpp"
#include "plica/estimation/packed_solver.hpp"

namespace plica {
namespace {

constexpr int pack = BlockMatrix::pack;
using Packed = std::vector<double>;  // [pack * unknown + lane]

/// Motion of `pack` columns.
struct Columns {
  explicit Columns(std::size_t length)
      : u(length, 0.0),
        v(length, 0.0),
        a(length, 0.0),
        a1(length, 0.0),
        a2(length, 0.0),
        U(length, 0.0),
        V(length, 0.0),
        source(length, 0.0),
        force(length),
        product(length) {}
  Packed u, v, a;
  Packed a1, a2;  // of the two steps before: the next solve starts from 3 a - 3 a1 + a2
  Packed U, V;    // (1+al) u1 - al u0 and likewise v1
  Packed source;  // force of the step, N
  Packed force, product;
};

struct Marching {
  const LinearMotion& m;
  const PackedSolver& solver;

  /// One step under c.source; leaves U and V of the finished step.
  void advance(Columns& c, std::ptrdiff_t step) const {
    const double h = m.step, al = m.alpha;
    const double ua = h * h * (0.5 - m.beta), va = (1 - m.gamma) * h;
    for (std::size_t i = 0; i < c.u.size(); ++i) {
      const double u0 = c.u[i], v0 = c.v[i];
      c.u[i] += h * v0 + ua * c.a[i];
      c.v[i] += va * c.a[i];
      c.U[i] = (1 + al) * c.u[i] - al * u0;
      c.V[i] = (1 + al) * c.v[i] - al * v0;
    }
    c.force = c.source;
    subtract(m.K, c.U, c.product, c.force);
    if (m.C) subtract(*m.C, c.V, c.product, c.force);
    project(c.force);
    for (std::size_t i = 0; i < c.a.size(); ++i) {
      const double guess = 3 * (c.a[i] - c.a1[i]) + c.a2[i];
      c.a2[i] = c.a1[i];
      c.a1[i] = c.a[i];
      c.a[i] = guess;
    }
    solver.solve(c.force, c.a, step);
    const double du = m.beta * h * h, dv = m.gamma * h;
    for (std::size_t i = 0; i < c.u.size(); ++i) {
      c.u[i] += du * c.a[i];
      c.v[i] += dv * c.a[i];
      c.U[i] += (1 + al) * du * c.a[i];
      c.V[i] += (1 + al) * dv * c.a[i];
    }
  }

  /// force -= A x
  static void subtract(const BlockMatrix& A, const Packed& x, Packed& product, Packed& force) {
    for_chunks(A.rows() / 3, BlockMatrix::chunk_rows,
               [&](std::ptrdiff_t begin, std::ptrdiff_t end, std::ptrdiff_t) {
                 A.multiply_rows_packed(begin, end, x.data(), product.data());
                 for (std::ptrdiff_t i = 3 * pack * begin; i < 3 * pack * end; ++i)
                   force[static_cast<std::size_t>(i)] -= product[static_cast<std::size_t>(i)];
               });
  }

  void project(Packed& force) const {
    for (std::ptrdiff_t k = 0; k < m.supports.size(); ++k)
      if (m.supports.fixed(k)) std::fill_n(force.begin() + pack * k, pack, 0.0);
  }
};

/// Packs of columns one after another: column c is lane c % pack of pack c / pack.
struct Group {
  Group(std::ptrdiff_t columns, std::size_t length)
      : count(columns), packs(static_cast<std::size_t>((columns + pack - 1) / pack), Columns(length)) {}
  std::ptrdiff_t count;
  std::vector<Columns> packs;
  Columns& of(std::ptrdiff_t column) { return packs[static_cast<std::size_t>(column / pack)]; }

  void clear_sources() {
    for (Columns& c : packs) std::fill(c.source.begin(), c.source.end(), 0.0);
  }
  void advance(const Marching& marching, std::ptrdiff_t step) {
    if (packs.size() == 1) {  // the kernels inside take the threads
      marching.advance(packs.front(), step);
      return;
    }
    std::vector<std::string> failed(packs.size());  // work must not throw
    for_chunks(static_cast<std::ptrdiff_t>(packs.size()), 1,
               [&](std::ptrdiff_t k, std::ptrdiff_t, std::ptrdiff_t) {
                 try {
                   marching.advance(packs[static_cast<std::size_t>(k)], step);
                 } catch (const std::exception& error) {
                   failed[static_cast<std::size_t>(k)] = error.what();
                 }
               });
    for (const std::string& text : failed)
      if (!text.empty()) throw SolveFailed(text);
  }
  void record(const Indices& observed, std::ptrdiff_t first, std::ptrdiff_t width, double* out) const {
    for (std::ptrdiff_t o = 0; o < observed.size(); ++o)
      for (std::ptrdiff_t c = 0; c < count; ++c)
        out[o * width + first + c] =
            packs[static_cast<std::size_t>(c / pack)].u[static_cast<std::size_t>(pack * observed[o] + c % pack)];
  }
};

/// source = -(dK U + dC V) of the base columns, one direction after another.
void take_sources(const std::vector<Direction>& directions, const Group& base, Group& derivatives) {
  const std::ptrdiff_t q = base.count;
  for_chunks(static_cast<std::ptrdiff_t>(directions.size()), 1,
             [&](std::ptrdiff_t j, std::ptrdiff_t, std::ptrdiff_t) {
               const Direction& direction = directions[static_cast<std::size_t>(j)];
               for (std::size_t p = 0; p < base.packs.size(); ++p) {
                 Packed force(base.packs[p].u.size(), 0.0), product(force.size());
                 if (direction.stiffness)
                   Marching::subtract(*direction.stiffness, base.packs[p].U, product, force);
                 if (direction.viscosity)
                   Marching::subtract(*direction.viscosity, base.packs[p].V, product, force);
                 const auto from = static_cast<std::ptrdiff_t>(p) * pack;
                 for (std::ptrdiff_t i = from; i < std::min(q, from + pack); ++i) {
                   const std::ptrdiff_t column = j * q + i;
                   Packed& target = derivatives.of(column).source;
                   for (std::size_t k = 0; k < force.size() / pack; ++k)
                     target[pack * k + static_cast<std::size_t>(column % pack)] =
                         force[pack * k + static_cast<std::size_t>(i % pack)];
                 }
               }
             });
}

void require_sizes(const LinearMotion& motion, const RowMatrix& patterns, const Indices& observed,
                   std::ptrdiff_t steps, double tolerance) {
  const std::ptrdiff_t unknowns = motion.K.rows();
  const std::string where = "impulse_responses";
  if (patterns.rows() != unknowns)
    throw InvalidInput(where, "rows of patterns", static_cast<double>(patterns.rows()), "",
                       "the number of unknowns, " + number(static_cast<double>(unknowns)));
  if (patterns.cols() < 1) throw InvalidInput(where, "columns of patterns", 0, "", ">= 1");
  if (steps < 1) throw InvalidInput(where, "steps", static_cast<double>(steps), "", ">= 1");
  if (!(tolerance > 0 && tolerance < 1)) throw InvalidInput(where, "tolerance", tolerance, "", "in (0, 1)");
  if (!(motion.step > 0)) throw InvalidInput(where, "step", motion.step, "s", "> 0");
  if (!patterns.allFinite()) throw InvalidInput(where + ": patterns must be finite.");
  for (const auto o : observed)
    if (o < 0 || o >= unknowns)
      throw InvalidInput(where, "observed unknown", o, "",
                         "in [0, " + number(static_cast<double>(unknowns)) + ")");
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
                            std::ptrdiff_t steps, double tolerance) {
  require_sizes(motion, patterns, observed, steps, tolerance);
  const std::ptrdiff_t q = patterns.cols(), width = (1 + static_cast<std::ptrdiff_t>(directions.size())) * q;
  const auto length = static_cast<std::size_t>(pack * motion.K.rows());
  const BlockMatrix A = step_matrix(motion);
  const PackedSolver solver(A, tolerance);
  const Marching marching{motion, solver};
  Group base(q, length), derivatives(width - q, length);
  for (std::ptrdiff_t i = 0; i < q; ++i)
    for (std::ptrdiff_t k = 0; k < patterns.rows(); ++k)
      base.of(i).source[static_cast<std::size_t>(pack * k + i % pack)] = patterns(k, i);
  RowMatrix out(steps, observed.size() * width);
  for (std::ptrdiff_t s = 0; s < steps; ++s) {
    base.advance(marching, s);
    base.record(observed, 0, width, out.row(s).data());
    if (!directions.empty()) {
      take_sources(directions, base, derivatives);
      derivatives.advance(marching, s);
      derivatives.record(observed, q, width, out.row(s).data());
    }
    if (s == 0) base.clear_sources();
  }
  return out;
}

}  // namespace plica
