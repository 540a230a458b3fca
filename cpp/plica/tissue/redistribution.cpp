// The mass matrix of tissue whose contact nodes have no mass; docs/theory/massless.md.
#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "plica/core/eigenpairs.hpp"
#include "plica/core/error.hpp"
#include "plica/core/require.hpp"
#include "plica/tissue/assembly.hpp"
#include "plica/tissue/element.hpp"

namespace plica {
namespace {

/// Moments of a mass about 1, x, y, z: mass, mass times centre, second moments.
using Moments = Eigen::Matrix4d;
using Ten = Eigen::Matrix<double, 10, 1>;
using LocalMass = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor, 10, 10>;

/// Of a symmetric matrix, such that products of two are those of the matrices, sum_ij A_ij B_ij.
Ten ten(const Moments& m) {
  const double r = std::sqrt(2.0);
  Ten v;
  v << m(0, 0), r * m(0, 1), r * m(0, 2), r * m(0, 3), m(1, 1), m(2, 2), m(3, 3), r * m(1, 2), r * m(2, 3),
      r * m(3, 1);
  return v;
}

/// The mass matrix of one cell, kg.
LocalMass cell_mass(const Element& element, double density, CellMass kind) {
  const int n = element.nodes();
  LocalMass m(n, n);
  element.mass(m.data());
  m *= density;
  if (kind == CellMass::consistent) return m;
  const double scale = density * element.volume() / m.trace();  // diagonal scaling, see Assembler::lumped_mass
  return (scale * m.diagonal()).asDiagonal();
}

/// Nodes that do not move, of bodies that are held, take no mass and have none to give: they count nowhere below.
struct Cell {
  double mass = 0.0;                  // kg, of all its nodes
  Vector3 centre = Vector3::Zero();   // m, of that mass, from the body's middle
  int inner = 0, massless = 0;        // nodes with mass and without
  Moments moments = Moments::Zero();  // of its inner nodes' part of the mass matrix, about the body's middle
  bool carries = false;               // has mass in the end
  double factor = 1.0;                // by which its part is multiplied
};

struct Body {
  std::vector<std::int32_t> nodes, cells;
  Vector3 middle = Vector3::Zero();
  Moments moments = Moments::Zero();  // of the whole mass, about the middle
};

/// Cells without massless nodes and those with three inner nodes, a face, carry mass; so do those of an inner node
/// that no such cell has. `left_out` (n): nodes that are massless or do not count.
void choose_carriers(const TetMesh& mesh, const std::vector<char>& left_out, std::vector<Cell>& cells) {
  std::vector<char> covered = left_out;
  for (std::size_t c = 0; c < cells.size(); ++c) {
    cells[c].carries = cells[c].massless == 0 || cells[c].inner >= 3;
    if (!cells[c].carries) continue;
    for (const auto node : mesh.cells.row(static_cast<std::ptrdiff_t>(c)))
      covered[static_cast<std::size_t>(node)] = 1;
  }
  for (std::size_t c = 0; c < cells.size(); ++c) {
    const auto row = mesh.cells.row(static_cast<std::ptrdiff_t>(c));
    cells[c].carries = cells[c].carries || std::any_of(row.begin(), row.end(), [&](std::int32_t node) {
                         return !covered[static_cast<std::size_t>(node)];
                       });
  }
}

/// (m) kg that each cell carries: the others hand theirs on, over massless nodes that they share, to the nearest
/// one.
Vector carried_mass(const TetMesh& mesh, const std::vector<char>& massless, const std::vector<Cell>& cells) {
  std::vector<std::vector<std::int32_t>> cells_at(massless.size());
  for (std::int32_t c = 0; c < mesh.cell_count(); ++c)
    for (const auto node : mesh.cells.row(c))
      if (massless[static_cast<std::size_t>(node)]) cells_at[static_cast<std::size_t>(node)].push_back(c);
  const auto around = [&](std::int32_t c) {
    std::vector<std::int32_t> found;
    for (const auto node : mesh.cells.row(c)) {
      const auto& there = cells_at[static_cast<std::size_t>(node)];
      found.insert(found.end(), there.begin(), there.end());
    }
    std::sort(found.begin(), found.end());
    found.erase(std::unique(found.begin(), found.end()), found.end());
    return found;
  };
  const auto place = [&](std::int32_t c) -> Vector3 {
    const Cell& cell = cells[static_cast<std::size_t>(c)];
    return cell.carries && cell.inner > 0 ? Vector3(cell.moments.col(0).tail<3>() / cell.moments(0, 0))
                                          : cell.centre;
  };
  Vector carried(mesh.cell_count());
  Indices ring = Indices::Constant(mesh.cell_count(), -1);
  std::vector<std::int32_t> order;
  for (std::int32_t c = 0; c < mesh.cell_count(); ++c) {
    const Cell& cell = cells[static_cast<std::size_t>(c)];
    carried[c] = cell.mass;
    if (!cell.carries || cell.inner == 0) continue;
    ring[c] = 0;
    order.push_back(c);
  }
  for (std::size_t k = 0; k < order.size(); ++k)
    for (const auto next : around(order[k]))
      if (ring[next] < 0) {
        ring[next] = ring[order[k]] + 1;
        order.push_back(next);
      }
  for (; !order.empty() && ring[order.back()] > 0; order.pop_back()) {
    const std::int32_t from = order.back();
    std::vector<std::int32_t> to = around(from);
    to.erase(std::remove_if(to.begin(), to.end(), [&](std::int32_t c) { return ring[c] != ring[from] - 1; }),
             to.end());
    const auto distance = [&](std::int32_t c) { return (place(c) - place(from)).norm(); };
    double nearest = distance(to.front());
    for (const auto c : to) nearest = std::min(nearest, distance(c));
    to.erase(
        std::remove_if(to.begin(), to.end(), [&](std::int32_t c) { return distance(c) > 1.000001 * nearest; }),
        to.end());  // several where they are as near
    for (const auto c : to) carried[c] += carried[from] / static_cast<double>(to.size());
    carried[from] = 0;
  }
  return carried;
}

[[noreturn]] void refuse(const Body& body, const std::string& name, double value, const std::string& relation) {
  const Vector3 centre = body.middle + Vector3(body.moments.col(0).tail<3>() / body.moments(0, 0));
  throw InvalidInput("Contact with redistributed mass",
                     name + " in the body of node " + std::to_string(body.nodes.front()) + ", centred at (" +
                         number_text(centre[0]) + ", " + number_text(centre[1]) + ", " + number_text(centre[2]) +
                         ") m",
                     value, "", relation,
                     "Too little of it lies behind its contact surfaces, of " + std::to_string(body.nodes.size()) +
                         " nodes: refine it to four cells or more in depth, or keep the mass of the surface.");
}

/// Multiplies the factors of a body's cells by exp(q), q the mean over the cell's mass of a polynomial of second
/// degree whose ten coefficients restore the moments of the whole mass: Newton's method on a convex function.
void restore_moments(const Body& body, std::vector<Cell>& cells) {
  constexpr int most_rounds = 40;
  // In y = L^-1 (X - centre), L L^T the second moments a mass, the whole mass has the unit matrix for its moments.
  const double mass = body.moments(0, 0);
  const Vector3 centre = body.moments.col(0).tail<3>() / mass;
  const Matrix3 L =
      Matrix3(body.moments.bottomRightCorner<3, 3>() / mass - centre * centre.transpose()).llt().matrixL();
  Moments to_y = Moments::Identity();
  to_y.bottomRightCorner<3, 3>() = L.inverse();
  to_y.col(0).tail<3>() = -to_y.bottomRightCorner<3, 3>() * centre;

  std::vector<Cell*> carriers;
  for (const auto c : body.cells)
    if (cells[static_cast<std::size_t>(c)].carries) carriers.push_back(&cells[static_cast<std::size_t>(c)]);
  Eigen::Matrix<double, 10, Eigen::Dynamic> t(10, carriers.size());
  for (std::size_t k = 0; k < carriers.size(); ++k)
    t.col(static_cast<Eigen::Index>(k)) =
        carriers[k]->factor / mass * ten(to_y * carriers[k]->moments * to_y.transpose());
  const Eigen::Matrix<double, Eigen::Dynamic, 10> means = (t * t.row(0).cwiseInverse().asDiagonal()).transpose();

  Vector growth = Vector::Ones(t.cols()), q = Vector::Zero(t.cols());
  double off = 0;
  for (int round = 0; round < most_rounds; ++round) {
    const Ten missing = ten(Moments::Identity()) - t * growth;
    off = missing.norm();
    if (off <= 1e-14) break;
    const Eigenpairs modes = symmetric_eigenpairs(t * growth.asDiagonal() * means);
    const Ten weights = modes.values;
    // Moments that repeat each other, as on a single row of cells, have no weight of their own.
    const Ten inverse = (weights.array() > 1e-10 * weights[9]).select(weights.cwiseInverse(), 0.0);
    Vector step = means * (modes.vectors * (inverse.asDiagonal() * (modes.vectors.transpose() * missing)));
    q += step / std::max(1.0, step.cwiseAbs().maxCoeff());
    growth = q.array().exp();
  }
  if (!(off <= 1e-12)) refuse(body, "error of a moment", off, "<= 1e-12");
  for (std::size_t k = 0; k < carriers.size(); ++k) carriers[k]->factor *= growth[static_cast<Eigen::Index>(k)];
}

}  // namespace

NodalMatrix Assembler::redistributed_mass(const Tissue& tissue, CellMass kind,
                                          const MassTransfer& transfer) const {
  const std::vector<char>&massless = transfer.massless, &held = transfer.held, &free = transfer.free;
  tissue.validate(mesh_);
  if (mesh_.stretched())
    throw InvalidInput(
        "Assembler: redistributed mass of stretched tissue; must be kept. Leave the posture out, or "
        "surface_mass.");
  const auto marks = [](const std::vector<char>& of) { return static_cast<std::ptrdiff_t>(of.size()); };
  require_size("MassTransfer", "massless", marks(massless), mesh_.node_count());
  require_size("MassTransfer", "held", marks(held), mesh_.node_count());
  require_size("MassTransfer", "free", marks(free), mesh_.node_count());
  const std::ptrdiff_t n = mesh_.cells.cols();
  const Indices body_of = body_of_nodes(mesh_);
  std::vector<Body> bodies(static_cast<std::size_t>(mesh_.node_count()));
  for (std::int32_t i = 0; i < mesh_.node_count(); ++i) {
    Body& body = bodies[static_cast<std::size_t>(body_of[i])];
    body.nodes.push_back(i);
    body.middle += mesh_.points.row(i).transpose();
  }
  for (Body& body : bodies)
    if (!body.nodes.empty()) body.middle /= static_cast<double>(body.nodes.size());

  Element element(mesh_.order());
  const auto mass_of = [&](std::ptrdiff_t c) {
    element.place(mesh_.points, mesh_.cells.row(c).data());
    return cell_mass(element, tissue.materials[static_cast<std::size_t>(tissue.cell_material[c])].density, kind);
  };
  std::vector<char> left_out = massless;
  const auto counts = [&](std::int32_t node) {
    return !held[static_cast<std::size_t>(node)] || free[static_cast<std::size_t>(node)];
  };
  for (std::int32_t i = 0; i < mesh_.node_count(); ++i)
    if (!counts(i)) left_out[static_cast<std::size_t>(i)] = 1;
  std::vector<Cell> cells(static_cast<std::size_t>(mesh_.cell_count()));
  for (std::int32_t c = 0; c < mesh_.cell_count(); ++c) {
    Cell& cell = cells[static_cast<std::size_t>(c)];
    Body& body = bodies[static_cast<std::size_t>(body_of[mesh_.cells(c, 0)])];
    body.cells.push_back(c);
    Eigen::Matrix<double, Eigen::Dynamic, 4, 0, 10, 4> whole(n, 4), inner;
    whole.setZero();
    for (std::ptrdiff_t a = 0; a < n; ++a)
      if (counts(mesh_.cells(c, a)))
        whole.row(a) << 1.0, mesh_.points.row(mesh_.cells(c, a)) - body.middle.transpose();
    inner = whole;
    for (std::ptrdiff_t a = 0; a < n; ++a) {
      const auto node = static_cast<std::size_t>(mesh_.cells(c, a));
      if (massless[node]) inner.row(a).setZero();
      cell.massless += massless[node] != 0;
      cell.inner += !left_out[node];
    }
    const LocalMass m = mass_of(c);
    const Moments moments = whole.transpose() * m * whole;
    cell.mass = moments(0, 0);
    if (cell.mass > 0) cell.centre = moments.col(0).tail<3>() / cell.mass;
    cell.moments = inner.transpose() * m * inner;
    body.moments += moments;
  }

  choose_carriers(mesh_, left_out, cells);
  const Vector carried = carried_mass(mesh_, massless, cells);
  for (const Body& body : bodies) {
    const auto loses = [&](std::int32_t node) { return massless[static_cast<std::size_t>(node)] != 0; };
    if (std::none_of(body.nodes.begin(), body.nodes.end(), loses)) continue;
    if (std::all_of(body.nodes.begin(), body.nodes.end(),
                    [&](std::int32_t node) { return left_out[static_cast<std::size_t>(node)] != 0; }))
      refuse(body, "number of moving nodes with mass", 0, ">= 1");
    double stranded = 0.0;
    for (const auto c : body.cells) {
      Cell& cell = cells[static_cast<std::size_t>(c)];
      if (!cell.carries) stranded += carried[c];
      if (cell.massless > 0) cell.factor = cell.carries ? carried[c] / cell.moments(0, 0) : 0.0;
    }
    if (stranded > 1e-12 * body.moments(0, 0)) refuse(body, "mass (kg) with no moving node near", stranded, "0");
    if (free[static_cast<std::size_t>(body.nodes.front())]) restore_moments(body, cells);
  }

  NodalMatrix M(pattern_);
  for (std::ptrdiff_t c = 0; c < mesh_.cell_count(); ++c) {
    const Cell& cell = cells[static_cast<std::size_t>(c)];
    if (!cell.carries) continue;
    const LocalMass m = mass_of(c);
    for (std::ptrdiff_t a = 0; a < n; ++a)
      for (std::ptrdiff_t b = 0; b < n; ++b)
        if (!massless[static_cast<std::size_t>(mesh_.cells(c, a))] &&
            !massless[static_cast<std::size_t>(mesh_.cells(c, b))])
          M.values()[static_cast<std::size_t>(scatter_[static_cast<std::size_t>((c * n + a) * n + b)])] +=
              cell.factor * m(a, b);
  }
  return M;
}

}  // namespace plica
