#include "plica/contact/contacts.hpp"

#include <algorithm>

namespace plica {

void Contacts::add_forces(Vector& nodal) const {
  for (std::size_t i = 0; i < rows.size(); ++i) rows[i].add_force(force[static_cast<std::ptrdiff_t>(i)], nodal);
}

std::ptrdiff_t Contacts::place_of(std::int32_t key) const {
  const auto at = std::lower_bound(constraints.begin(), constraints.end(), key,
                                   [](const Constraint& c, std::int32_t k) { return c.key < k; });
  return at != constraints.end() && at->key == key ? at - constraints.begin() : -1;
}

double Contacts::force_of(std::int32_t key) const {
  const std::ptrdiff_t i = place_of(key);
  return i < 0 ? 0.0 : force[i];
}

std::pair<std::vector<std::int32_t>, Vector> Contacts::closed() const {
  std::vector<std::int32_t> keys;
  std::vector<double> forces;
  for (std::size_t i = 0; i < constraints.size(); ++i) {
    const double p = force[static_cast<std::ptrdiff_t>(i)];
    if (!(p > 0)) continue;
    keys.push_back(constraints[i].key);
    forces.push_back(p);
  }
  return {std::move(keys), Eigen::Map<const Vector>(forces.data(), static_cast<std::ptrdiff_t>(forces.size()))};
}

}  // namespace plica
