#include "plica/airflow/air_column.hpp"

#include <cmath>

#include "plica/core/error.hpp"

namespace plica {

Gas gas_of(const Airflow::Options& flow, double sound_speed) {
  return {flow.air_density, sound_speed, flow.air_viscosity()};
}

namespace {

constexpr std::size_t secants_kept = 2;
constexpr std::ptrdiff_t memory_head = 18;  // numbers of a memory before its arrays

}  // namespace

// Whether the flow is stopped; sizes: secants, numbers of each of their halves, sections, trachea, tract; the
// interval, source, flows, works. Then the arrays: secants, momenta, trachea, tract.
std::vector<double> AirColumn::Memory::numbers() const {
  const auto size_of = [](const Vector& values) { return static_cast<double>(values.size()); };
  std::vector<double> numbers{flow_stopped ? 1.0 : 0.0,
                              static_cast<double>(secants.size()),
                              secants.empty() ? 0.0 : size_of(secants[0].image),
                              size_of(momentum),
                              size_of(trachea),
                              size_of(tract),
                              interval,
                              source,
                              flow_below,
                              flow_above};
  for (const LineWork& work : {trachea_work, tract_work})
    for (const double value : {work.port, work.source, work.radiated, work.lost}) numbers.push_back(value);
  const auto add = [&](const Vector& values) { numbers.insert(numbers.end(), values.begin(), values.end()); };
  for (const auto& [image, residual] : secants) {
    add(image);
    add(residual);
  }
  for (const Vector* values : {&momentum, &momentum_before, &trachea, &tract}) add(*values);
  return numbers;
}

AirColumn::Memory AirColumn::Memory::of(const std::vector<double>& numbers) {
  const auto count = static_cast<double>(numbers.size());
  const auto refused = [&](const std::string& relation) {
    return InvalidInput("AirColumn", "numbers of its memory", count, "", relation);
  };
  if (count < memory_head) throw refused("the " + std::to_string(memory_head) + " of its head and more");
  if (numbers[0] != 0 && numbers[0] != 1)
    throw InvalidInput("AirColumn", "first number of its memory", numbers[0], "",
                       "0 or 1, whether the flow is stopped");
  for (std::size_t i = 1; i <= 5; ++i)
    if (!(numbers[i] >= 0 && numbers[i] <= count && numbers[i] == std::floor(numbers[i])))
      throw InvalidInput("AirColumn", "size in its memory", numbers[i], "",
                         "a whole number in [0, " + number_text(count) + "]");
  const double told = memory_head + 2 * numbers[1] * numbers[2] + 2 * numbers[3] + numbers[4] + numbers[5];
  if (count != told) throw refused("the " + number_text(told) + " of the sizes in its head");
  Memory memory;
  memory.flow_stopped = numbers[0] == 1;
  memory.interval = numbers[6];
  memory.source = numbers[7];
  memory.flow_below = numbers[8];
  memory.flow_above = numbers[9];
  memory.trachea_work = {numbers[10], numbers[11], numbers[12], numbers[13]};
  memory.tract_work = {numbers[14], numbers[15], numbers[16], numbers[17]};
  const double* at = numbers.data() + memory_head;
  const auto next = [&](double size) -> Vector {
    const double* begin = at;
    at += static_cast<std::ptrdiff_t>(size);
    return Eigen::Map<const Vector>(begin, at - begin);
  };
  for (int k = 0; k < numbers[1]; ++k) memory.secants.push_back({next(numbers[2]), next(numbers[2])});
  memory.momentum = next(numbers[3]);
  memory.momentum_before = next(numbers[3]);
  memory.trachea = next(numbers[4]);
  memory.tract = next(numbers[5]);
  return memory;
}

AirColumn::Side::Side(const Tube& tube, const Gas& gas, const char* where, double step)
    : line(tube, gas, where), regular(line, step) {}

LineStep& AirColumn::Side::begin(double duration, double regular_duration) {
  if (duration == regular_duration) {
    taken = &regular;
  } else {
    first.emplace(line, duration);
    taken = &*first;
  }
  return *taken;
}

AirColumn::AirColumn(const Airflow& airflow, double step, const Tubes& tubes)
    : airflow_(&airflow), step_(step), inertial_(airflow.options().has_inertance()) {
  if (!tubes.any()) return;
  tubes.validate();
  const Gas gas = gas_of(airflow.options(), tubes.sound_speed);
  if (tubes.trachea) trachea_.emplace(*tubes.trachea, gas, "Trachea", step);
  if (tubes.tract) tract_.emplace(*tubes.tract, gas, "Tract", step);
  const auto* supply = tubes.trachea ? std::get_if<FlowSupply>(&tubes.trachea->end) : nullptr;
  const bool closed = tubes.tract && std::holds_alternative<FlowSupply>(tubes.tract->end);
  if ((supply || closed) && !(airflow.options().rise > 0))
    throw InvalidInput("Airflow", "rise", airflow.options().rise, "s",
                       "> 0 where a flow is supplied or the tract is closed", "It begins in still air.");
  if (supply) supplied_flow_ = supply->flow;
}

double AirColumn::source(const Air& air) const {
  if (!supplied_flow_) return air.subglottal_pressure;
  return *supplied_flow_ * air.subglottal_pressure / airflow_->options().subglottal_pressure;
}

FlowState AirColumn::start(const Vector& areas) {
  now_ = {};
  air_last_ = air_weighted_ = airflow_->air(0.0);
  if (!has_tubes()) {
    FlowState flow = evaluate(areas, Instant::last);
    now_.momentum = now_.momentum_before = flow.momentum;
    return flow;
  }
  now_.source = source(air_last_);  // of a flow 0, and no pressure either
  if (trachea_) air_last_.subglottal_impedance = trachea_->line.steady_resistance();
  if (tract_) air_last_.supraglottal_impedance = tract_->line.steady_resistance();
  const FlowState flow = evaluate(areas, Instant::last);
  now_.momentum = now_.momentum_before = flow.momentum;
  now_.flow_below = flow.flow_below;
  now_.flow_above = flow.flow_above;
  if (trachea_) now_.trachea = trachea_->line.steady(-flow.flow_below, now_.source);
  if (tract_) now_.tract = tract_->line.steady(flow.flow_above, 0.0);
  return flow;
}

void AirColumn::begin_step(const Memory& memory, double last, double ahead, Instant load) {
  now_ = memory;
  air_last_ = airflow_->air(last);
  air_weighted_ = airflow_->air(last + ahead);
  if (!has_tubes() && !inertial_) return;
  duration_ = last > 0 ? step_ : load == Instant::last ? 0.0 : ahead;
  if (has_tubes()) {
    Air& air = load == Instant::last ? air_last_ : air_weighted_;
    begin_tubes(memory, air);
    (load == Instant::last ? air_weighted_ : air_last_) = air;  // what is compared with the load has its tubes
  }
  if (inertial_) begin_inertia(memory);
}

void AirColumn::begin_tubes(const Memory& memory, Air& air) {
  source_then_ = source(air);
  if (trachea_) {
    LineStep& line = trachea_->begin(duration_, step_);
    line.begin(memory.trachea, -memory.flow_below, memory.source, source_then_);
    air.subglottal_pressure = line.pressure();
    air.subglottal_impedance = line.impedance();
  }
  if (tract_) {
    LineStep& line = tract_->begin(duration_, step_);
    line.begin(memory.tract, memory.flow_above, 0.0, 0.0);
    air.supraglottal_pressure = line.pressure();
    air.supraglottal_impedance = line.impedance();
  }
}

void AirColumn::begin_inertia(const Memory& memory) {
  if (duration_ == 0) return;                                                // the flow has always been so
  const double w = memory.interval > 0 ? duration_ / memory.interval : 0.0;  // of the last two steps
  inertia_.rate = (1 + 2 * w) / ((1 + w) * duration_);
  inertia_.past = ((1 + w) * memory.momentum - w * w / (1 + w) * memory.momentum_before) / duration_;
  air_last_.inertia = air_weighted_.inertia = &inertia_;
}

FlowState AirColumn::evaluate(const Vector& areas, Instant at, const std::optional<Held>& held,
                              const AirwayExpansion* moving) const {
  if (held) return airflow_->evaluate(areas, air(at), held->stopped, held->separation, moving);
  return airflow_->evaluate(areas, air(at), stopped(), std::nullopt, moving);
}

void AirColumn::remember(Secant secant) {
  now_.secants.push_back(std::move(secant));
  if (now_.secants.size() > secants_kept) now_.secants.erase(now_.secants.begin());
}

AirColumn::Memory AirColumn::end_step(const FlowState& flow) {
  if (trachea_) now_.trachea = trachea_->taken->end(-flow.flow_below, &now_.trachea_work);
  if (tract_) now_.tract = tract_->taken->end(flow.flow_above, &now_.tract_work);
  if (has_tubes()) {
    now_.source = source_then_;
    now_.flow_below = flow.flow_below;
    now_.flow_above = flow.flow_above;
  }
  if (inertial_) {
    now_.momentum_before.swap(now_.momentum);
    now_.momentum = flow.momentum;
    now_.interval = duration_;
  }
  return now_;
}

void AirColumn::require(const Memory& memory) const {
  const auto check = [](const char* name, const Vector& values, const std::optional<Side>& side) {
    const std::ptrdiff_t size = side ? side->line.size() : 0;
    if (values.size() != size)
      throw InvalidInput("Simulation", std::string("numbers of the state's ") + name,
                         static_cast<double>(values.size()), "", std::to_string(size),
                         "It belongs to another scene.");
    if (!values.allFinite())
      throw InvalidInput(std::string("Simulation: the state's ") + name + " has a value that is not finite.");
  };
  for (const Vector* momentum : {&memory.momentum, &memory.momentum_before}) {
    const std::ptrdiff_t size = inertial_ ? airflow_->sections().count() : 0;
    if (momentum->size() != size)
      throw InvalidInput("Simulation", "numbers of the momentum of the state's air",
                         static_cast<double>(momentum->size()), "", std::to_string(size),
                         "It belongs to another scene.");
    if (!momentum->allFinite())
      throw InvalidInput("Simulation: the momentum of the state's air has a value that is not finite.");
  }
  if (memory.secants.size() > secants_kept)
    throw InvalidInput("Simulation", "secants of the state's air", static_cast<double>(memory.secants.size()), "",
                       "at most " + std::to_string(secants_kept));
  for (const auto& [image, residual] : memory.secants)
    for (const Vector* values : {&image, &residual}) {
      const std::ptrdiff_t size = has_tubes() ? airflow_->sections().count() + 2 : 0;
      if (values->size() != size)
        throw InvalidInput("Simulation", "pressures of a secant of the state's air",
                           static_cast<double>(values->size()), "", std::to_string(size),
                           "It belongs to another scene.");
      if (!values->allFinite())
        throw InvalidInput("Simulation: a secant of the state's air has a value that is not finite.");
    }
  if (!(memory.interval >= 0) || !std::isfinite(memory.interval))
    throw InvalidInput("Simulation", "interval of the state's air", memory.interval, "s", ">= 0 and finite");
  check("trachea", memory.trachea, trachea_);
  check("tract", memory.tract, tract_);
  const LineWork& below = memory.trachea_work;
  const LineWork& above = memory.tract_work;
  for (const double value : {memory.source, memory.flow_below, memory.flow_above, below.port, below.source,
                             below.radiated, below.lost, above.port, above.source, above.radiated, above.lost})
    if (!std::isfinite(value))
      throw InvalidInput("Simulation: the state's flows and works of the air must be finite.");
}

double AirColumn::lip_flow(const Memory& memory) const {
  return tract_ ? tract_->line.end_flow(memory.tract, 0.0) : memory.flow_above;
}

double AirColumn::supply_rise(const Memory& memory) const {
  return memory.source / supplied_flow_.value_or(airflow_->options().subglottal_pressure);
}

double AirColumn::tube_energy(const Memory& memory) const {
  return (trachea_ ? trachea_->line.energy(memory.trachea) : 0.0) +
         (tract_ ? tract_->line.energy(memory.tract) : 0.0);
}

}  // namespace plica
