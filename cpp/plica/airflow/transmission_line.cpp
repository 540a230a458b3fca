#include "plica/airflow/transmission_line.hpp"

#include <cmath>

#include "plica/core/constants.hpp"
#include "plica/core/error.hpp"
#include "plica/core/require.hpp"

namespace plica {

TransmissionLine::TransmissionLine(const Tube& tube, const Gas& gas, const char* where, double longest)
    : walls_(tube.wall) {
  tube.validate(where);
  std::vector<double> length, area;
  for (std::size_t i = 0; i < tube.length.size(); ++i) {
    const int count = static_cast<int>(std::ceil(tube.length[i] / longest * (1 - 1e-12)));
    length.insert(length.end(), static_cast<std::size_t>(count), tube.length[i] / count);
    area.insert(area.end(), static_cast<std::size_t>(count), tube.area[i]);
  }
  const auto count = static_cast<std::ptrdiff_t>(length.size());
  const double stiffness = gas.density * gas.sound_speed * gas.sound_speed;  // Pa
  const double layer = std::sqrt(pi * tube.friction_frequency * gas.density * gas.viscosity);
  compliance_ = wall_area_ = Vector::Zero(count + 1);
  inertance_.resize(count);
  friction_.resize(count);
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    const double l = length[static_cast<std::size_t>(i)], A = area[static_cast<std::size_t>(i)];
    const double perimeter = 2 * std::sqrt(pi * A);
    inertance_[i] = gas.density * l / A;
    friction_[i] = perimeter * layer * l / (A * A);
    compliance_.segment<2>(i).array() += 0.5 * l * A / stiffness;
    wall_area_.segment<2>(i).array() += 0.5 * l * perimeter;
  }
  const double A = area.back(), characteristic = gas.density * gas.sound_speed / A;
  if (std::holds_alternative<Radiation>(tube.end)) {
    end_ = End::radiating;
    end_resistance_ = 128 / (9 * pi * pi) * characteristic;
    end_inertance_ = 8 * std::sqrt(A / pi) / (3 * pi) * gas.density / A;
  } else if (const auto* supply = std::get_if<PressureSupply>(&tube.end)) {
    end_resistance_ = characteristic * (1 - supply->reflection) / (1 + supply->reflection);
    end_ = end_resistance_ > 0 ? End::resistive : End::held;
    compliance_[count] += supply->volume / stiffness;
  } else {
    end_ = End::supplied;
    compliance_[count] += std::get<FlowSupply>(tube.end).volume / stiffness;
  }
}

double TransmissionLine::steady_resistance() const {
  if (end_ == End::supplied) return 0;
  return friction_.sum() + (end_ == End::resistive ? end_resistance_ : 0.0);
}

Vector TransmissionLine::steady(double flow, double source) const {
  const std::ptrdiff_t n = nodes();
  Vector state = Vector::Zero(size());
  auto pressure = state.head(n);
  pressure[n - 1] = end_ == End::held ? source : end_ == End::resistive ? source + end_resistance_ * flow : 0.0;
  for (std::ptrdiff_t k = n - 2; k >= 0; --k) pressure[k] = pressure[k + 1] + friction_[k] * flow;
  state.segment(n, n - 1).setConstant(flow);
  if (walls_) state.segment(3 * n - 1, n) = wall_area_.cwiseProduct(pressure) / walls_->stiffness;
  if (end_ == End::radiating) state[size() - 1] = flow;
  return state;
}

double TransmissionLine::energy(const Vector& state) const {
  require_size("TransmissionLine", "state", state.size(), size());
  const std::ptrdiff_t n = nodes();
  double twice = compliance_.dot(state.head(n).cwiseAbs2()) + inertance_.dot(state.segment(n, n - 1).cwiseAbs2());
  if (walls_) {
    const auto flow = state.segment(2 * n - 1, n).array(), volume = state.segment(3 * n - 1, n).array();
    twice += ((walls_->mass * flow.square() + walls_->stiffness * volume.square()) / wall_area_.array()).sum();
  }
  if (end_ == End::radiating) twice += end_inertance_ * state[size() - 1] * state[size() - 1];
  return 0.5 * twice;
}

double TransmissionLine::end_flow(const Vector& state, double source) const {
  require_size("TransmissionLine", "state", state.size(), size());
  const std::ptrdiff_t n = nodes();
  const double pressure = state[n - 1];
  switch (end_) {
    case End::radiating:
      return pressure / end_resistance_ + state[size() - 1];
    case End::resistive:
      return (pressure - source) / end_resistance_;
    case End::supplied:
      return -source;
    case End::held:
      break;
  }
  return state[2 * n - 2] - (walls_ ? state[3 * n - 2] : 0.0);
}

TransmissionLine::Response TransmissionLine::response(std::complex<double> s) const {
  using Complex = std::complex<double>;
  if (!std::isfinite(s.real()) || !std::isfinite(s.imag()) || s == 0.0)
    throw InvalidInput("TransmissionLine: the growth rate of its response must be finite and not 0.");
  const auto shunt = [&](std::ptrdiff_t k) {
    Complex admittance = s * compliance_[k];
    if (walls_) admittance += wall_area_[k] / (s * walls_->mass + walls_->resistance + walls_->stiffness / s);
    return admittance;
  };
  // From the far end on, of what is the scale there.
  const std::ptrdiff_t n = nodes();
  Complex out = 0.0, pressure = 1.0, flow;
  if (end_ == End::held) {
    pressure = 0.0;
    out = flow = 1.0;
  } else {
    if (end_ == End::radiating) out = 1 / end_resistance_ + 1.0 / (s * end_inertance_);
    if (end_ == End::resistive) out = 1 / end_resistance_;
    flow = out + shunt(n - 1);
  }
  for (std::ptrdiff_t k = n - 2; k >= 0; --k) {
    pressure += (s * inertance_[k] + friction_[k]) * flow;
    flow += shunt(k) * pressure;
  }
  return {pressure / flow, out / flow};
}

LineStep::LineStep(const TransmissionLine& line, double duration, double longest)
    : line_(line),
      count_(static_cast<int>(std::ceil(duration / longest * (1 - 1e-12)))),
      substep_(count_ > 0 ? duration / count_ : 0.0) {
  if (!(duration >= 0) || !std::isfinite(duration))
    throw InvalidInput("LineStep", "duration", duration, "s", ">= 0 and finite");
  if (!(longest > 0) || !std::isfinite(longest))
    throw InvalidInput("LineStep", "longest", longest, "s", "> 0 and finite");
  if (count_ == 0) return;
  const std::ptrdiff_t n = line.nodes();
  const double twice = 2 / substep_;
  storing_ = twice * line.compliance_;
  along_ = (twice * line.inertance_ + line.friction_).cwiseInverse();
  carried_ = twice * along_.cwiseProduct(line.inertance_);
  Vector diagonal = storing_;
  diagonal.head(n - 1) += along_;
  diagonal.tail(n - 1) += along_;
  if (line.walls_) {
    const auto& [mass, resistance, stiffness] = *line.walls_;
    const double impedance = twice * mass + resistance + stiffness / twice;
    shunt_ = line.wall_area_ / impedance;
    wall_carried_ = twice * mass / impedance;
    wall_held_ = stiffness / impedance;
    diagonal += shunt_;
  }
  using End = TransmissionLine::End;
  if (line.end_ == End::radiating) diagonal[n - 1] += 1 / line.end_resistance_ + 1 / (twice * line.end_inertance_);
  if (line.end_ == End::resistive) diagonal[n - 1] += 1 / line.end_resistance_;
  inverse_pivots_.resize(n);
  down_ = up_ = Vector::Zero(n);
  for (std::ptrdiff_t k = 0; k < n; ++k) {
    if (k > 0) down_[k] = along_[k - 1] * inverse_pivots_[k - 1];
    inverse_pivots_[k] = 1 / (diagonal[k] - (k > 0 ? down_[k] * along_[k - 1] : 0.0));
    if (k + 1 < n) up_[k] = along_[k] * inverse_pivots_[k];
  }
  added_ = Vector::Zero(line.size());
  run(added_, {0.0, 1.0, 0.0, 0.0}, added_borders_);
  impedance_ = added_[0];
}

void LineStep::begin(const Vector& state, double flow, double source, double source_then) {
  require_size("LineStep", "state", state.size(), line_.size());
  state_ = without_ = state;
  flow_ = flow;
  source_ = source;
  source_then_ = source_then;
  run(without_, {flow, 0.0, source, source_then}, without_borders_);
  pressure_ = without_[0];
}

Vector LineStep::end(double flow, LineWork* work) const {
  require_size("LineStep", "state that its step began from", state_.size(), line_.size());
  if (count_ == 0) return state_;
  Vector state = without_ + flow * added_;
  if (work) add_work(flow, state, *work);
  return state;
}

double LineStep::source_at(int substep) const {
  return source_ + (substep + 0.5) / count_ * (source_then_ - source_);
}

void LineStep::add_work(double flow, const Vector& state, LineWork& work) const {
  using End = TransmissionLine::End;
  const Vector near = without_borders_.near + flow * added_borders_.near;
  const Vector far = without_borders_.far + flow * added_borders_.far;
  const Vector inward = without_borders_.inward + flow * added_borders_.inward;
  double port = 0, source = 0, radiated = 0;
  for (int i = 0; i < count_; ++i) {
    port += near[i] * (flow_ + (i + 0.5) / count_ * (flow - flow_));
    if (line_.end_ == End::radiating)
      radiated += far[i] * far[i] / line_.end_resistance_;
    else
      source += (line_.end_ == End::supplied ? far[i] : source_at(i)) * inward[i];
  }
  work.port += substep_ * port;
  work.source += substep_ * source;
  work.radiated += substep_ * radiated;
  work.lost += substep_ * (port + source - radiated) - (line_.energy(state) - line_.energy(state_));
}

void LineStep::run(Vector& state, const Path& path, Borders& borders) const {
  for (Vector* values : {&borders.near, &borders.far, &borders.inward}) values->setZero(count_);
  for (int i = 0; i < count_; ++i) {
    const double at = (i + 0.5) / count_;
    substep(state, path.flow + at * (path.flow_then - path.flow),
            path.source + at * (path.source_then - path.source), borders, i);
  }
}

void LineStep::substep(Vector& state, double flow, double source, Borders& borders, int at) const {
  using End = TransmissionLine::End;
  const std::ptrdiff_t n = line_.nodes();
  const bool yields = line_.walls_.has_value(), held = line_.end_ == End::held;
  auto p = state.head(n).array();
  auto U = state.segment(n, n - 1).array();
  auto U_wall = state.segment(2 * n - 1, yields ? n : 0).array();
  auto V_wall = state.segment(yields ? 3 * n - 1 : 2 * n - 1, yields ? n : 0).array();
  double& U_end = state[state.size() - 1];  // of a radiating end
  // Of the middle of the substep: right-hand side, then pressure.
  middle_ = storing_.array() * p;
  flows_ = carried_.array() * U;
  middle_.head(n - 1) -= flows_;
  middle_.tail(n - 1) += flows_;
  if (yields) {
    walls_ = wall_carried_ * U_wall - wall_held_ * V_wall;
    middle_ -= walls_;
  }
  middle_[0] += flow;
  if (line_.end_ == End::radiating) middle_[n - 1] -= U_end;
  if (line_.end_ == End::resistive) middle_[n - 1] += source / line_.end_resistance_;
  if (line_.end_ == End::supplied) middle_[n - 1] += source;
  for (std::ptrdiff_t k = 1; k < n; ++k) middle_[k] += down_[k] * middle_[k - 1];
  middle_.array() *= inverse_pivots_.array();
  if (held) middle_[n - 1] = source;
  for (std::ptrdiff_t k = n - 2; k >= 0; --k) middle_[k] += up_[k] * middle_[k + 1];

  flows_.array() += along_.array() * (middle_.head(n - 1) - middle_.tail(n - 1)).array();
  if (yields) walls_.array() += shunt_.array() * middle_.array();
  borders.near[at] = middle_[0];
  borders.far[at] = middle_[n - 1];
  if (line_.end_ == End::resistive)
    borders.inward[at] = (source - middle_[n - 1]) / line_.end_resistance_;
  else if (line_.end_ == End::supplied)
    borders.inward[at] = source;
  else if (held)  // what is stored in half an element, and what its wall makes room for
    borders.inward[at] =
        storing_[n - 1] * (middle_[n - 1] - p[n - 1]) + (yields ? walls_[n - 1] : 0.0) - flows_[n - 2];
  if (line_.end_ == End::radiating) U_end += substep_ * middle_[n - 1] / line_.end_inertance_;
  p = 2 * middle_.array() - p;
  U = 2 * flows_.array() - U;
  if (!yields) return;
  U_wall = 2 * walls_.array() - U_wall;
  V_wall += substep_ * walls_.array();
}

}  // namespace plica
