#pragma once
#include "plica/contact/collision.hpp"
#include "plica/dynamics/record.hpp"

namespace plica {

struct State;
class Step;

/// What contact did in a step that ended in the state `now` at x (n, 3), the positions of the collision's last
/// update, judged by its own nodes.
ContactRecord contact_record(Collision& collision, const Step& step, const State& now, const Points& x);

}  // namespace plica
