#pragma once
#include "plica/dynamics/reduced_step.hpp"
#include "plica/dynamics/scene.hpp"
#include "plica/dynamics/state.hpp"

namespace plica {

/// A scene in the coordinates of its reduction: motion, airflow and contact, and one step of them.
class ReducedModel {
 public:
  /// The scene has a reduction; scene, its motion and its air (null without airflow) must outlive it. Throws
  /// InvalidInput for what cannot be reduced.
  ReducedModel(const Scene& scene, const Motion& full, AirColumn* air);

  ReducedModel(const ReducedModel&) = delete;
  ReducedModel& operator=(const ReducedModel&) = delete;

  const ModalMotion& motion() const { return motion_; }
  const Mediolateral& positions() const { return positions_; }
  const ReducedFlow* flow() const { return flow_ ? &*flow_ : nullptr; }
  ReducedContact* contact() const { return contact_.get(); }
  /// Unknowns of the contact's own nodes.
  std::ptrdiff_t interface() const { return contact_ ? 3 * contact_->nodes().size() : 0; }

  /// Of a state of t = 0 in all nodes: that in coordinates, completed.
  State begun(const State& full);
  void restore(const State& state);

  /// What a step did.
  struct Taken {
    std::optional<FlowRecord> flow;
    std::optional<ContactRecord> contact;
  };
  /// The step from `last` under the scene's load (r) at t_{n+1+alpha} to `now`, another state whose memory is
  /// used. Throws SolveFailed.
  Taken step(const State& last, const Vector& scene_load, StepTimes& times, State& now);

 private:
  const Scene& scene_;
  const Motion& full_;
  ModalMotion motion_;
  Mediolateral positions_;
  std::optional<ReducedFlow> flow_;
  AirColumn* air_;
  std::unique_ptr<ReducedContact> contact_;
  std::optional<ReducedStep> step_;  // from construction on
};

}  // namespace plica
