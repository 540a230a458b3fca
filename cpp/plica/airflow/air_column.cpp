#include "plica/airflow/air_column.hpp"

namespace plica {

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
