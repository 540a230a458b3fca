#include "plica/airflow/line_system.hpp"

namespace plica {

LineSystem line_system(const TransmissionLine& line) {
  using End = TransmissionLine::End;
  const bool held = line.end_ == End::held, radiating = line.end_ == End::radiating;
  const std::ptrdiff_t elements = line.elements(), nodes = line.nodes() - held, walls = line.walls_ ? nodes : 0;
  const std::ptrdiff_t flows = nodes, wall_flows = flows + elements, wall_volumes = wall_flows + walls,
                       end = wall_volumes + walls;
  const std::ptrdiff_t size = end + radiating;
  LineSystem system{Vector(size), Eigen::MatrixXd::Zero(size, size), Vector::Zero(size), Vector::Zero(size)};
  auto& [E, A, c, b] = system;
  E.head(nodes) = line.compliance_.head(nodes);
  E.segment(flows, elements) = line.inertance_;
  for (std::ptrdiff_t k = 0; k < elements; ++k) {
    const std::ptrdiff_t flow = flows + k;
    A(k, flow) = -1;
    A(flow, k) = 1;
    A(flow, flow) = -line.friction_[k];
    if (k + 1 == nodes) continue;
    A(k + 1, flow) = 1;
    A(flow, k + 1) = -1;
  }
  for (std::ptrdiff_t k = 0; k < walls; ++k) {
    const double area = line.wall_area_[k], stiffness = line.walls_->stiffness / area;
    const std::ptrdiff_t flow = wall_flows + k, volume = wall_volumes + k;
    E[flow] = line.walls_->mass / area;
    E[volume] = stiffness;
    A(k, flow) = -1;
    A(flow, k) = 1;
    A(flow, flow) = -line.walls_->resistance / area;
    A(flow, volume) = -stiffness;
    A(volume, flow) = stiffness;
  }
  if (held) {
    c[flows + elements - 1] = 1;
    b[flows + elements - 1] = -1;
  }
  if (line.end_ == End::supplied) b[nodes - 1] = 1;
  if (line.end_ == End::resistive || radiating) {
    c[nodes - 1] = 1 / line.end_resistance_;
    A(nodes - 1, nodes - 1) -= c[nodes - 1];
    if (!radiating) b[nodes - 1] = c[nodes - 1];
  }
  if (radiating) {
    c[end] = 1;
    E[end] = line.end_inertance_;
    A(nodes - 1, end) = -1;
    A(end, nodes - 1) = 1;
  }
  return system;
}

}  // namespace plica
