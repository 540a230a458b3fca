#pragma once
#include <optional>

#include "plica/dynamics/coupling.hpp"
#include "plica/dynamics/reduced_contact.hpp"
#include "plica/dynamics/reduced_flow.hpp"
#include "plica/dynamics/state.hpp"

namespace plica {

/// As Step, of the coordinates of a reduced motion: M a + C V + K U = load + contact_force. One product with A^-1,
/// under what neither section pressures nor contact make; what these add is superposed, at once in the positions
/// that they are found from, in all coordinates at the end.
class ReducedStep final : public CoupledStep, private FreeEnd {
 public:
  /// flow and contact are null where there is none. All must outlive it.
  ReducedStep(const ModalMotion& motion, const Mediolateral& positions, ReducedFlow* flow, ReducedContact* contact,
              const Vector3& origin)
      : motion_(motion), positions_(positions), flow_(flow), contact_(contact), origin_(origin) {}

  /// A step begins from the state `last`, under scene_load (r) at t_{n+1+alpha} and, until it is moved, the
  /// pressure at the `ends`, whose sections are not read; last and times must live until its end. One object
  /// takes all steps of a run: its memory stays.
  void begin(const State& last, const Vector& scene_load, const AirwayPressure& ends, StepTimes& times);
  /// Moves it under the scene's load alone.
  void move();
  void move(const AirwayPressure& pressure, Instant at) override;
  Vector areas(Instant at) const override;
  AirwayExpansion expansion(Instant at) const override;
  bool blocks() const override;
  StepTimes& times() const override { return *times_; }

  /// Writes the state that it leads to, its ledger, first signs and depth still those of the last.
  void end(State& now);

 private:
  void predict();
  Vector load_of_ends(const AirwayPressure& ends) const;
  /// The acceleration that neither section pressures nor contact make, and the positions it leads to.
  void solve_without();
  void touch();
  const Vector& contact_x() const override { return contact_x_; }
  Vector free_end() const override;
  Vector free_acceleration() const;  // without contact
  const std::array<AirwayExpansion, 2>& expansions() const;
  double inertia() const { return motion_.scheme().inertia(motion_.step()); }
  double weight() const { return motion_.scheme().weight(); }

  const ModalMotion& motion_;
  const Mediolateral& positions_;
  ReducedFlow* flow_;
  ReducedContact* contact_;
  const Vector3& origin_;

  // Fixed within the step, (r) unless said otherwise.
  const State* last_ = nullptr;
  StepTimes* times_ = nullptr;
  Vector displacement_predictor_, velocity_predictor_, viscous_predictor_, inner_force_;
  Vector elastic_behind_, viscous_behind_;
  Vector scene_load_;
  AirwayPressure ends_of_free_;              // that of free_, no sections
  Vector free_;                              // (r) acceleration without section pressures and contact
  Vector free_weighted_x_, free_contact_x_;  // (n) m at t_{n+1+alpha} and (c) m at t_{n+1}, where that leads
  // At t_{n+1+alpha}, extrapolated and where that leads; once asked for.
  mutable std::optional<std::array<AirwayExpansion, 2>> expansions_;
  // Of this move.
  AirwayPressure pressure_;
  Vector moving_;                   // what of it free_ has not; empty before the first and without airflow
  Vector weighted_x_;               // (n) m at t_{n+1+alpha}; extrapolated before the first
  Vector contact_x_;                // (c) m at t_{n+1}, without contact
  Eigen::VectorXf x_acceleration_;  // (n) m/s^2 of the pressure
  // Workspace.
  Vector force_, end_, acceleration_;  // (r)
  TwoColumns ends_;                    // (r, 2)
};

}  // namespace plica
