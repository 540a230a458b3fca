#include "plica/imaging/flow.hpp"

#include <cmath>
#include <string>
#include <vector>

#include "plica/core/error.hpp"
#include "plica/core/threads.hpp"
#include "plica/imaging/linearise.hpp"
#include "plica/imaging/median.hpp"
#include "plica/imaging/resample.hpp"

namespace plica::imaging {
namespace {

constexpr std::ptrdiff_t smallest_side = 8;  // px, of a picture
constexpr double coarsest_side = 16;         // px, of a pyramid's last level
constexpr float edge_slope = 30;   // grey levels per px: what a known motion weighs is what a fold's edge does
constexpr float normal_slope = 8;  // the same among channels that are divided by their slope

void require(bool holds, const char* name, double value, const char* unit, const char* relation) {
  if (!holds) throw InvalidInput("FlowOptions", name, value, unit, relation);
}

void require_picture(const Plane& image, const Plane& first, const std::string& name) {
  const auto size = [](const Plane& plane) {
    return std::to_string(plane.cols()) + " x " + std::to_string(plane.rows()) + " px";
  };
  if (image.rows() != first.rows() || image.cols() != first.cols()) {
    throw InvalidInput("dense_flow: " + name + " is " + size(image) + "; must be " + size(first) +
                       " like the first picture.");
  }
  if (std::min(image.rows(), image.cols()) < smallest_side) {
    throw InvalidInput("dense_flow: the pictures are " + size(first) + "; must have sides of at least " +
                       std::to_string(smallest_side) + " px.");
  }
  if (!image.isFinite().all()) {
    for (std::ptrdiff_t y = 0; y < image.rows(); ++y) {
      for (std::ptrdiff_t x = 0; x < image.cols(); ++x) {
        if (!std::isfinite(image(y, x))) {
          throw InvalidInput("dense_flow: " + name + " has " + number_text(image(y, x)) + " at row " +
                             std::to_string(y) + ", column " + std::to_string(x) + "; must be finite.");
        }
      }
    }
  }
}

/// rho'(e) / e of alpha E_quad + (1 - alpha) E with rho(e) = log(1 + e^2 / (2 scale^2)), Eqs. (5) and (6), or
/// sqrt(1 + e^2 / scale^2), and rho_quad(e) = e^2 / quadratic_scale^2.
Weight weight(PenaltyShape penalty, double alpha, double scale, double quadratic_scale) {
  if (penalty == PenaltyShape::charbonnier) {
    return {static_cast<float>(alpha * 2 / (quadratic_scale * quadratic_scale)),
            static_cast<float>((1 - alpha) / scale), static_cast<float>(scale * scale), true};
  }
  if (penalty == PenaltyShape::quadratic) alpha = 1;
  return {static_cast<float>(alpha * 2 / (quadratic_scale * quadratic_scale)), static_cast<float>((1 - alpha) * 2),
          static_cast<float>(2 * scale * scale)};
}

/// What does not change as things move, in the first picture and in the second.
struct Channel {
  Plane first;
  Spline second;
};

struct Level {
  Plane first, second;
  std::vector<Channel> channels;  // brightness, or the two components of its gradient, in the light of the first
  Plane used, sides;
  Plane measured, displacement;  // share of the pixel whose motion is known; the motion, in pixels of this level
};

std::vector<Level> make_levels(const Plane& first, const Plane& second, const Known& known, int count,
                               double spacing) {
  auto firsts = pyramid(first, count, spacing), seconds = pyramid(second, count, spacing);
  std::vector<Level> levels(firsts.size());
  for (std::size_t i = 0; i < levels.size(); ++i) {
    levels[i].first = std::move(firsts[i]);
    levels[i].second = std::move(seconds[i]);
  }
  const auto spread = [&](const Plane& plane, Plane Level::*to) {
    if (plane.size() == 0) return;
    auto planes = pyramid(plane, count, spacing);
    for (std::size_t i = 0; i < levels.size(); ++i) levels[i].*to = std::move(planes[i]);
  };
  spread(known.used, &Level::used);
  spread(known.sides, &Level::sides);
  spread(known.measured, &Level::measured);
  spread(known.displacement, &Level::displacement);
  for (Level& level : levels) {
    if (level.measured.size() == 0) continue;
    const double ratio = std::abs(known.across[0]) > std::abs(known.across[1])
                             ? static_cast<double>(level.first.cols()) / static_cast<double>(first.cols())
                             : static_cast<double>(level.first.rows()) / static_cast<double>(first.rows());
    level.displacement =
        (level.measured > 1e-3F).select(static_cast<float>(ratio) * level.displacement / level.measured, 0.0F);
  }
  return levels;
}

void set_channels(const Plane& first, const Plane& second, bool of_gradient, Level& level) {
  level.channels.clear();
  if (of_gradient) {
    Gradient one = gradient(first);
    const Gradient two = gradient(second);
    level.channels.push_back({std::move(one.x), Spline(two.x)});
    level.channels.push_back({std::move(one.y), Spline(two.y)});
  } else {
    level.channels.push_back({first, Spline(second)});
  }
}

/// The light at the present flow, where it may change, and what stays in it.
void set_light(const FlowOptions& options, const LitFlow& flow, Level& level, Light& light) {
  const bool of_gradient = options.gradient_noise.has_value();
  if (options.light == LightChange::none) return set_channels(level.first, level.second, of_gradient, level);
  light = fit_light(level.first, level.second, Spline(level.second), level.used, flow.u, flow.v);
  const Relit relit = relight(level.first, level.second, light);
  set_channels(relit.first, relit.second, of_gradient, level);
}

/// u0 + (u - u0) with the change bounded.
void bound_change(const Plane& u0, float largest, Plane& u) {
  for_chunks(u.rows(), chunk_rows(u.cols()), [&](std::ptrdiff_t begin, std::ptrdiff_t end, std::ptrdiff_t) {
    auto rows = u.middleRows(begin, end - begin);
    const auto before = u0.middleRows(begin, end - begin);
    rows = before + (rows - before).max(-largest).min(largest);
  });
}

/// The known motion along `across` as one more channel: its error is a distance times `slope`.
void add_edge_motion(const Level& level, const std::array<double, 2>& across, float slope, const Flow& flow,
                     Linearisation& result) {
  const auto x = slope * static_cast<float>(across[0]), y = slope * static_cast<float>(across[1]);
  result.trust = level.measured;
  result.ix = x * level.measured;
  result.iy = y * level.measured;
  result.it = level.measured * (x * flow.u + y * flow.v - slope * level.displacement);
}

void solve_stage(std::vector<Level>& levels, const FlowOptions& options, Weight data_weight, Weight smooth_weight,
                 const std::array<double, 2>& across, LitFlow& flow) {
  const auto lambda = static_cast<float>(options.smoothness);
  const bool measured = levels.front().measured.size() > 0;
  std::vector<Linearisation> data((options.gradient_noise ? 2 : 1) + (measured ? 1 : 0));
  Flow next;
  for (std::size_t i = levels.size(); i-- > 0;) {
    Level& level = levels[i];
    const std::ptrdiff_t rows = level.first.rows(), columns = level.first.cols();
    const auto along = static_cast<float>(static_cast<double>(columns) / static_cast<double>(flow.u.cols()));
    const auto down = static_cast<float>(static_cast<double>(rows) / static_cast<double>(flow.u.rows()));
    flow.u = along * resize(flow.u, rows, columns);
    flow.v = down * resize(flow.v, rows, columns);
    if (level.channels.empty()) set_light(options, flow, level, flow.light);
    FlowSystem system(rows, columns);
    for (int warp = 0; warp < options.warps; ++warp) {
      for (std::size_t k = 0; k < level.channels.size(); ++k) {
        linearise(level.channels[k].first, level.channels[k].second, level.used, flow.u, flow.v, data[k]);
        if (options.gradient_noise) normalise(static_cast<float>(*options.gradient_noise), data[k]);
      }
      if (measured)
        add_edge_motion(level, across, options.gradient_noise ? normal_slope : edge_slope, flow, data.back());
      system.assemble(data, flow.u, flow.v, data_weight, smooth_weight, lambda, level.sides);
      system.sweep(options.sweeps, static_cast<float>(options.relaxation));
      system.read(next.u, next.v);
      bound_change(flow.u, static_cast<float>(options.largest_step), next.u);
      bound_change(flow.v, static_cast<float>(options.largest_step), next.v);
      median_5x5(next.u, flow.u);
      median_5x5(next.v, flow.v);
    }
  }
}

}  // namespace

void FlowOptions::validate() const {
  const auto bounded = [](double value, double least, double most, const char* name, const char* unit) {
    require(value >= least && value <= most, name, value, unit,
            ("in [" + number_text(least) + ", " + number_text(most) + "]").c_str());
  };
  bounded(smoothness, 1e-6, 1e6, "smoothness", "");
  bounded(data_scale, 1e-3, 1e3, "data_scale", gradient_noise ? "px" : "grey levels");
  bounded(smooth_scale, 1e-4, 100, "smooth_scale", "px per px");
  if (gradient_noise) bounded(*gradient_noise, 1e-3, 1e3, "gradient_noise", "grey levels per px^2");
  bounded(stages, 1, 20, "stages", "");
  if (levels) bounded(*levels, 1, 20, "levels", "");
  require(spacing > 1 && spacing <= 4, "spacing", spacing, "", "in (1, 4]");
  bounded(fine_levels, 1, 20, "fine_levels", "");
  require(fine_spacing > 1 && fine_spacing <= 4, "fine_spacing", fine_spacing, "", "in (1, 4]");
  bounded(warps, 1, 100, "warps", "");
  bounded(largest_step, 1e-3, 100, "largest_step", "px");
  bounded(sweeps, 1, 1000, "sweeps", "");
  require(relaxation > 0 && relaxation < 2, "relaxation", relaxation, "", "in (0, 2)");
}

LitFlow dense_flow(const Plane& first, const Plane& second, const FlowOptions& options, const Known& known) {
  options.validate();
  require_picture(first, first, "the first picture");
  require_picture(second, first, "the second picture");
  if (known.used.size() > 0) require_picture(known.used, first, "the mask");
  if (known.sides.size() > 0) require_picture(known.sides, first, "the picture of sides");
  if (known.measured.size() > 0) {
    require_picture(known.measured, first, "where motion is measured");
    require_picture(known.displacement, first, "the motion that is measured");
    const double length = std::hypot(known.across[0], known.across[1]);
    if (!(std::abs(length - 1) < 1e-6))
      throw InvalidInput("dense_flow", "length of across", length, "", "1",
                         "It is the direction of what is measured.");
  }

  const auto deepest = [&](double spacing) {
    const double side = static_cast<double>(std::min(first.rows(), first.cols()));
    return 1 +
           std::max(0, static_cast<int>(std::floor(std::log(side / coarsest_side) / std::log(spacing) + 1e-9)));
  };
  const int coarse = std::min(options.levels.value_or(20), deepest(options.spacing));
  const int fine = std::min(options.fine_levels, deepest(options.fine_spacing));

  LitFlow flow{{Plane::Zero(first.rows(), first.cols()), Plane::Zero(first.rows(), first.cols())}, {}};
  std::vector<Level> levels;
  for (int stage = 0; stage < options.stages; ++stage) {
    const double alpha = options.stages == 1 ? 0 : 1 - static_cast<double>(stage) / (options.stages - 1);
    if (stage < 2) {
      levels = make_levels(first, second, known, stage == 0 ? coarse : fine,
                           stage == 0 ? options.spacing : options.fine_spacing);
    }
    solve_stage(levels, options,
                weight(options.data_penalty, alpha, options.data_scale, options.data_scale / options.smooth_scale),
                weight(options.smooth_penalty, alpha, options.smooth_scale, 1), known.across, flow);
  }
  if (!flow.u.isFinite().all() || !flow.v.isFinite().all()) {
    throw SolveFailed("dense_flow: the flow is not finite (smoothness = " + number_text(options.smoothness) +
                      ", grey levels up to " +
                      number_text(std::max(first.abs().maxCoeff(), second.abs().maxCoeff())) +
                      "). Take grey levels of a range of 255 and options near their defaults.");
  }
  return flow;
}

}  // namespace plica::imaging
