#pragma once
#include "plica/dynamics/symmetric_part.hpp"

namespace plica {

/// Gravity, the loads of a scene and a force of the embedder's own, which depend on the time alone.
class SceneLoads {
 public:
  /// `part`: of a symmetric scene, else null; the assembler is its. Throws InvalidInput for a load that is not
  /// symmetric where the scene is.
  SceneLoads(const Scene& scene, const SymmetricPart* part, const Assembler& assembler);
  /// N at time t (s), of the motion's unknowns.
  Vector at(double t) const;
  /// N, of the motion's unknowns, held until it is replaced.
  void set_external(Vector force) { external_ = std::move(force); }
  /// From now on in coordinates: Phi^T of everything, the external force given so, too. shapes: Phi (3 n, r).
  void reduce(const Eigen::MatrixXd& shapes);

 private:
  std::vector<Load> loads_;
  // N, of the motion's unknowns.
  std::vector<Vector> amplitudes_;  // of each load at amplitude 1
  Vector constant_;
  Vector external_;  // or empty
};

}  // namespace plica
