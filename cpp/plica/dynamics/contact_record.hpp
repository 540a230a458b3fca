#pragma once
#include "plica/contact/collision.hpp"
#include "plica/dynamics/record.hpp"

namespace plica {

/// Of what is pressed on either side: loaded area (m^2, mean of both), anteroposterior length (m) of all that is
/// loaded, and largest pressure (Pa).
struct Pressed {
  double area = 0.0, length = 0.0, peak = 0.0;
};
Pressed measure(const std::vector<PressedNode>& first, const std::vector<PressedNode>& second);

/// What contact did in a step from x_before to x (n, 3), the positions of the collision's last update, where the
/// surfaces can be `reach` (m) deep in each other, judged by its own nodes. `now`: of the end of the step.
ContactRecord contact_record(Collision& collision, const Contacts& contacts, const Points& x_before, double reach,
                             const Contact& now, const Points& x);

}  // namespace plica
