#pragma once
#include <functional>

#include "plica/core/block_matrix.hpp"
#include "plica/dynamics/state.hpp"

namespace plica {

class ExcessForce;
class ModalMotion;
class Motion;

/// The products that a State carries so that no step computes them anew, held against its displacement, velocity
/// and acceleration. A few products with each matrix.
class StateProducts {
 public:
  explicit StateProducts(const Motion& motion);
  explicit StateProducts(const ModalMotion& motion);

  /// Throws InvalidInput naming the product, and by how much it differs, where one is not that of the state's
  /// motion to the round-off of steps that carry it on; the same of its ledger's kinetic and elastic energy. K U
  /// and C V of a step that weights two instants are not the state's alone: they count in its ledger, in no
  /// motion.
  void require(const State& state) const;
  /// The same motion with its products: K U and C V moved by as much as K u and C v have changed, the past without
  /// earlier steps, and the energy of the change counted as initial.
  State renewed(State state) const;

 private:
  using Product = std::function<Vector(const Vector&)>;
  /// A matrix, and the sums of its columns' magnitudes, by which round-off in a product is judged.
  struct Operator {
    Product times;
    Vector sums;
  };
  void require_products(const State& state) const;
  void require_energy(const char* name, double stored, double value, double magnitude) const;
  void require_product(const char* name, const char* product, const Vector& stored, const Operator& A,
                       const Vector& x, double magnitude) const;

  Operator M_, K_, C_, A_;                      // C_ and A_ without a product where there is none
  Vector first_displacement_, first_velocity_;  // U_0 - u_0, V_0 - v_0
  const ExcessForce* excess_ = nullptr;         // at finite strain
  double alpha_, step_;
  bool explicit_ = false, reduced_ = false;
  double inverse_damping_ = 0.0, inertia_ = 0.0;  // reduced: C a is found as (f - a - inertia K a) inverse_damping
};

}  // namespace plica
