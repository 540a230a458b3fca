#pragma once
#include "plica/core/types.hpp"

namespace plica {

/// How a fixed point x = H(x) answers: by how much two images H(x) differ, and those less what they are images of.
struct Secant {
  Vector image, residual;
};

}  // namespace plica
