#pragma once
// Small meshes and materials that several test files share.
#include <random>

#include "plica/mesh/block.hpp"
#include "plica/tissue/assembly.hpp"

namespace scenes {

using namespace plica;

inline Material transverse(double E, double nu, double E_fibre, double nu_fibre, double mu_fibre) {
  TransverselyIsotropic law;
  law.E = E;
  law.nu = nu;
  law.E_fibre = E_fibre;
  law.nu_fibre = nu_fibre;
  law.mu_fibre = mu_fibre;
  Material material;
  material.elasticity = law;
  return material;
}

/// An anisotropic material with its fibre along no axis.
inline Material oblique() {
  Material material = transverse(20e3, 0.45, 40e3, 0.3, 10e3);
  std::get<TransverselyIsotropic>(material.elasticity).fibre = Vector3(0.3, 1.0, -0.5);
  material.density = 1040;
  material.viscosity = 3;
  return material;
}

inline Tissue uniform(const TetMesh& mesh, const Material& material) {
  return {{material}, {"body"}, Indices::Zero(mesh.cell_count())};
}

/// Nodes that lie on the hull of the box [corner, corner + size].
inline std::vector<char> on_hull(const TetMesh& mesh, const Block& block) {
  std::vector<char> hull(static_cast<std::size_t>(mesh.node_count()), 0);
  for (std::ptrdiff_t i = 0; i < mesh.node_count(); ++i) {
    for (std::size_t d = 0; d < 3; ++d) {
      const double t = (mesh.points(i, static_cast<int>(d)) - block.corner[d]) / block.size[d];
      if (t < 1e-9 || t > 1 - 1e-9) hull[static_cast<std::size_t>(i)] = 1;
    }
  }
  return hull;
}

enum class Kind { linear, straight, curved };
inline const Kind kinds[] = {Kind::linear, Kind::straight, Kind::curved};

/// A block of 3 x 3 x 3 hexahedra, or so many each way, whose inner corners, and for curved elements inner middles
/// as well, are moved at random by up to 15 % (4 % for middles) of a hexahedron.
struct Distorted {
  Block block;
  TetMesh mesh;
  std::vector<char> hull;

  explicit Distorted(Kind kind, int divisions = 3)
      : block{{0.1, -0.2, 0.3}, {1.2, 0.9, 1.5}, {divisions, divisions, divisions}}, mesh(block_mesh(block)) {
    shake(0.15);
    if (kind != Kind::linear) mesh = to_quadratic(mesh);
    if (kind == Kind::curved) shake(0.04);
    hull = on_hull(mesh, block);
  }

 private:
  void shake(double amplitude) {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> shift(-amplitude, amplitude);
    const auto fixed = on_hull(mesh, block);
    for (std::ptrdiff_t i = 0; i < mesh.node_count(); ++i) {
      for (int d = 0; d < 3; ++d) {
        const double move = shift(random) * block.size[static_cast<std::size_t>(d)] / block.divisions[0];
        if (!fixed[static_cast<std::size_t>(i)]) mesh.points(i, d) += move;
      }
    }
  }
};

/// (3 n) the displacement u(x) = H (x - origin) at every node.
inline Vector affine_displacement(const TetMesh& mesh, const Matrix3& H) {
  Vector u(3 * mesh.node_count());
  as_points(u) = mesh.points * H.transpose();
  return u;
}

/// The symmetric displacement gradient of the Voigt strain that is one in `component`, zero elsewhere.
inline Matrix3 unit_strain(int component) {
  constexpr int pair[6][2] = {{0, 0}, {1, 1}, {2, 2}, {0, 1}, {1, 2}, {2, 0}};
  Matrix3 H = Matrix3::Zero();
  H(pair[component][0], pair[component][1]) += 0.5;
  H(pair[component][1], pair[component][0]) += 0.5;
  return H;
}

}  // namespace scenes
