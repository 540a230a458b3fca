#include "plica/tissue/node_stress.hpp"

#include <algorithm>
#include <map>

#include "plica/core/error.hpp"
#include "plica/mesh/edges.hpp"
#include "plica/tissue/element.hpp"

namespace plica {

namespace {

/// Engineering strain of a displacement of one node whose shape function has this gradient.
NodeStress::Slope strain_of(const Vector3& g) {
  NodeStress::Slope B = NodeStress::Slope::Zero();
  B(0, 0) = B(3, 1) = B(5, 2) = g[0];
  B(1, 1) = B(3, 0) = B(4, 2) = g[1];
  B(2, 2) = B(4, 1) = B(5, 0) = g[2];
  return B;
}

/// Barycentric coordinates of local node a.
std::array<double, 4> place_of(int a) {
  std::array<double, 4> at{};
  if (a < 4) {
    at[a] = 1.0;
  } else {
    at[tet_edges[a - 4][0]] = at[tet_edges[a - 4][1]] = 0.5;
  }
  return at;
}

}  // namespace

NodeStress::NodeStress(const TetMesh& mesh, const Tissue& tissue, const std::vector<std::int32_t>& nodes)
    : terms_(static_cast<std::size_t>(mesh.node_count())),
      elasticity_(static_cast<std::size_t>(mesh.node_count()), Matrix6::Zero()),
      density_(static_cast<std::size_t>(mesh.node_count()), 0.0) {
  if (mesh.stretched())
    throw InvalidInput(
        "Contact: Nitsche's method on stretched tissue; must be another: it sees the stress at rest. "
        "Leave the posture out, or choose another.");
  std::vector<char> wanted(static_cast<std::size_t>(mesh.node_count()), 0);
  for (const std::int32_t node : nodes) wanted[static_cast<std::size_t>(node)] = 1;
  std::vector<Matrix6> elasticity, viscosity;
  for (const Material& material : tissue.materials) {
    elasticity.push_back(elasticity_matrix(material));
    viscosity.push_back(viscosity_matrix(material));
  }

  std::map<std::int32_t, std::map<std::int32_t, Term>> found;
  std::map<std::int32_t, double> volume;
  Element element(mesh.cells.cols() == 10 ? 2 : 1);
  for (std::ptrdiff_t c = 0; c < mesh.cell_count(); ++c) {
    const std::int32_t* cell = mesh.cells.row(c).data();
    const int count = static_cast<int>(mesh.cells.cols());
    if (std::none_of(cell, cell + count,
                     [&](std::int32_t node) { return wanted[static_cast<std::size_t>(node)]; }))
      continue;
    element.place(mesh.points, cell);
    const Matrix6& S = elasticity[static_cast<std::size_t>(tissue.cell_material[c])];
    const Matrix6& eta = viscosity[static_cast<std::size_t>(tissue.cell_material[c])];
    for (int a = 0; a < count; ++a) {
      if (!wanted[static_cast<std::size_t>(cell[a])]) continue;
      const double share = element.volume();
      const auto gradients = element.gradients(place_of(a));
      volume[cell[a]] += share;
      elasticity_[static_cast<std::size_t>(cell[a])] += share * S;
      density_[static_cast<std::size_t>(cell[a])] +=
          share * tissue.materials[static_cast<std::size_t>(tissue.cell_material[c])].density;
      auto& of_node = found[cell[a]];
      for (int b = 0; b < count; ++b) {
        const Slope strain = share * strain_of(gradients.row(b));
        Term& term = of_node.try_emplace(cell[b], Term{cell[b], Slope::Zero(), Slope::Zero()}).first->second;
        term.elastic += S * strain;
        term.viscous += eta * strain;
      }
    }
  }
  for (const auto& [node, of_node] : found) {
    const double whole = volume.at(node);
    elasticity_[static_cast<std::size_t>(node)] /= whole;
    density_[static_cast<std::size_t>(node)] /= whole;
    for (const auto& [other, term] : of_node)
      terms_[static_cast<std::size_t>(node)].push_back({other, term.elastic / whole, term.viscous / whole});
  }
}

double NodeStress::modulus(std::int32_t node, const Vector3& n) const {
  const Vector6 dyad = normal_dyad(n);
  return dyad.dot(elasticity_[static_cast<std::size_t>(node)] * normal_dyad(n));
}

Vector6 normal_dyad(const Vector3& n) {
  Vector6 v;
  v << n[0] * n[0], n[1] * n[1], n[2] * n[2], 2 * n[0] * n[1], 2 * n[1] * n[2], 2 * n[2] * n[0];
  return v;
}

}  // namespace plica
