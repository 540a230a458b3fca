#pragma once
#include "scenes.hpp"

/// Scenes that move in a basis, for the tests of this folder.
namespace scenes {

/// The columns of the identity of what is free: nothing is left out.
inline Eigen::MatrixXd every_displacement(const Scene& scene) {
  std::vector<std::ptrdiff_t> free;
  for (std::ptrdiff_t i = 0; i < scene.supports.size(); ++i)
    if (!scene.supports.fixed(i)) free.push_back(i);
  Eigen::MatrixXd basis = Eigen::MatrixXd::Zero(scene.supports.size(), static_cast<std::ptrdiff_t>(free.size()));
  for (std::size_t j = 0; j < free.size(); ++j) basis(free[j], static_cast<std::ptrdiff_t>(j)) = 1.0;
  return basis;
}

inline Scene reduced(Scene scene, Eigen::MatrixXd basis) {
  scene.reduction = Reduction{std::move(basis), 1};
  return scene;
}

/// Of the part of a symmetric scene, each with its mirror images.
inline Eigen::MatrixXd every_symmetric_displacement(const Scene& scene, Symmetry symmetry) {
  const MirrorImages images(scene.mesh, symmetry);
  std::vector<Vector> columns;
  for (std::ptrdiff_t i = 0; i < 3 * images.nodes().size(); ++i) {
    const std::int32_t node = images.nodes()[i / 3];
    const auto axis = static_cast<std::size_t>(i % 3);
    if (axis < images.planes() && images.partner(axis, node) == node) continue;
    if (scene.supports.fixed(3 * static_cast<std::ptrdiff_t>(node) + i % 3)) continue;
    columns.push_back(images.spread(Vector::Unit(3 * images.nodes().size(), i)));
  }
  Eigen::MatrixXd basis(scene.supports.size(), static_cast<std::ptrdiff_t>(columns.size()));
  for (std::size_t j = 0; j < columns.size(); ++j) basis.col(static_cast<std::ptrdiff_t>(j)) = columns[j];
  return basis;
}

/// The folds alone: what lies above and below them is held, so that the dense algebra of all modes takes a moment.
inline Scene larynx_folds() {
  Scene scene = small_larynx();
  for (std::int32_t i = 0; i < scene.mesh.node_count(); ++i)
    if (std::abs(scene.mesh.points(i, 2)) > 2e-3) {
      scene.supports.fix(i);
      scene.velocity->row(i).setZero();
    }
  return scene;
}

/// The same where nothing moves in the plane between the folds.
inline Scene symmetric_folds() {
  Scene scene = larynx_folds();
  for (std::ptrdiff_t i = 0; i < scene.mesh.node_count(); ++i)
    if (scene.mesh.points(i, 0) == 0) scene.velocity->row(i).setZero();
  return scene;
}

}  // namespace scenes
