#pragma once

namespace plica {

/// Of the largest diagonal entry of a compliance: added to its diagonal, so that rows that repeat others, which
/// make it singular, share the force. Columns solved for to 1e-12 leave it indefinite by about their condition
/// times that; the motion is the same to this accuracy.
inline constexpr double shared_compliance = 1e-9;

}  // namespace plica
