#pragma once
#include <array>
#include <optional>

#include "plica/imaging/light.hpp"
#include "plica/imaging/plane.hpp"

namespace plica::imaging {

enum class PenaltyShape { lorentzian, charbonnier, quadratic };

/// Whether the light may change from the first picture to the second: not at all, or by a gain that varies slowly
/// over the picture and an offset, which are found with the flow.
enum class LightChange { none, smooth };

/// Algorithm 1 of Paper C as docs/imaging.md completes it. Intensities are grey levels of a range of 255.
struct FlowOptions {
  double smoothness = 0.045;  // lambda of Eq. (4): weight of smoothness against data, [1e-6, 1e6]
  double data_scale = 3.5;    // tau_D: data errors well above it are outliers; grey levels, or px with
                              // gradient_noise, [1e-3, 1e3]
  double smooth_scale = 0.1;  // tau_S: flow steps well above it are edges; px from pixel to pixel, [1e-4, 100]
  PenaltyShape data_penalty = PenaltyShape::lorentzian;
  PenaltyShape smooth_penalty = PenaltyShape::lorentzian;
  std::optional<double> gradient_noise;  // none: brightness stays as things move. Else its gradient does, and
                                         // slopes of it below this are noise; grey levels per px^2, [1e-3, 1e3]
  LightChange light = LightChange::smooth;
  int stages = 3;              // of graduated non-convexity, alpha = 1 ... 0; 1: alpha = 0 at once; [1, 20]
  std::optional<int> levels;   // of the first stage's pyramid, [1, 20]; none: down to sides of 16 px
  double spacing = 2;          // of the first stage's pyramid, in (1, 4]
  int fine_levels = 2;         // of the later stages' pyramid, [1, 20]
  double fine_spacing = 1.25;  // of the later stages' pyramid, in (1, 4]
  int warps = 10;              // at each level, [1, 100]
  double largest_step = 1;     // bound of each component's change in a warp, px, [1e-3, 100]
  int sweeps = 10;             // of the linear solver in each warp, [1, 1000]
  double relaxation = 1.9;     // of the linear solver, in (0, 2)
  void validate() const;       // throws InvalidInput
};

/// first(x, y) is seen again at second(x + u, y + v): px, v downwards, on the grid of the first picture.
struct Flow {
  Plane u, v;
};

/// A flow, and how the light changed.
struct LitFlow : Flow {
  Light light;
};

/// What is known of two pictures beside their brightness. Each plane may be empty: nothing is known.
struct Known {
  Plane
      used;  // 1 where the first picture's data count and 0 where not (darkness, highlights): smoothness fills in
  Plane sides;     // of the first picture: -1 and 1 on two sides that move apart, between which nothing is smooth;
                   // else 0
  Plane measured;  // 1 where the first picture's motion along `across` is known, else 0
  Plane displacement;                  // that motion, px; 0 where it is not known. As large as `measured`
  std::array<double, 2> across{1, 0};  // unit vector: right and down
};

/// The motion from `first` to `second`, both of the same size with sides of at least 8 px and finite values.
/// The same bits for any number of threads. Throws SolveFailed where single precision
/// overflows.
LitFlow dense_flow(const Plane& first, const Plane& second, const FlowOptions& options = {},
                   const Known& known = {});

}  // namespace plica::imaging
