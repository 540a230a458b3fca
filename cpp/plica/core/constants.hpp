#pragma once

namespace plica {

inline constexpr double pi = 3.14159265358979323846;

}  // namespace plica
