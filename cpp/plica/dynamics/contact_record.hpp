#pragma once
#include "plica/contact/collision.hpp"
#include "plica/dynamics/record.hpp"

namespace plica {

/// What contact did in a step from x_before, where the surfaces were `depth` (m) deep in each other, to x (n, 3),
/// the positions of the collision's last update, judged by its own nodes. `now`: of the end of the step.
ContactRecord contact_record(Collision& collision, const Contacts& contacts, const Points& x_before, double depth,
                             const Contact& now, const Points& x);

}  // namespace plica
