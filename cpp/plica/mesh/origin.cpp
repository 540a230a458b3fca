#include <cmath>

#include "plica/mesh/tet_mesh.hpp"

namespace plica {

Vector3 origin_near(const Points& x) {
  if (x.rows() == 0) return Vector3::Zero();
  const Vector3 low = x.colwise().minCoeff(), high = x.colwise().maxCoeff(), middle = 0.5 * (low + high);
  return (middle.array().abs() > (high - low).norm()).select(middle, 0.0);
}

}  // namespace plica
