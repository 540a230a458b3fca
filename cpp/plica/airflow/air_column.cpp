#include "plica/airflow/air_column.hpp"

#include "plica/core/error.hpp"

namespace plica {

std::vector<double> AirColumn::Memory::numbers() const { return {flow_stopped ? 1.0 : 0.0}; }

AirColumn::Memory AirColumn::Memory::of(const std::vector<double>& numbers) {
  if (numbers.size() != 1)
    throw InvalidInput("AirColumn", "numbers of its memory", static_cast<double>(numbers.size()), "", "1");
  return {numbers[0] != 0};
}

FlowState AirColumn::start(const Vector& areas) {
  begin_step({}, 0.0, 0.0);
  return evaluate(areas, Instant::last);
}

void AirColumn::begin_step(const Memory& memory, double last, double ahead) {
  now_ = memory;
  air_last_ = airflow_->air(last);
  air_weighted_ = airflow_->air(last + ahead);
}

FlowState AirColumn::evaluate(const Vector& areas, Instant at, const std::optional<Held>& held) const {
  if (held) return airflow_->evaluate(areas, air(at), held->stopped, held->separation);
  return airflow_->evaluate(areas, air(at), stopped());
}

}  // namespace plica
