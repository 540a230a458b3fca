#pragma once
#include "plica/dynamics/scene.hpp"

namespace plica {

/// Gravity, the loads of a scene and a force of the embedder's own, which depend on the time alone.
class SceneLoads {
 public:
  SceneLoads(const Scene& scene, const Assembler& assembler);
  /// (3 n) N at time t (s).
  Vector at(double t) const;
  /// (3 n) N, held until it is replaced.
  void set_external(Vector force) { external_ = std::move(force); }
  /// From now on in coordinates: Phi^T of everything, the external force given so, too. shapes: Phi (3 n, r).
  void reduce(const Eigen::MatrixXd& shapes);

 private:
  std::vector<Load> loads_;
  std::vector<Vector> amplitudes_;  // (3 n) N of each load at amplitude 1
  Vector constant_;                 // (3 n) N
  Vector external_;                 // (3 n) N, or empty
};

}  // namespace plica
