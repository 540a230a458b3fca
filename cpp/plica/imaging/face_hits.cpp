#include "plica/imaging/face_hits.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "plica/core/require.hpp"
#include "plica/core/threads.hpp"

namespace plica::imaging {
namespace {

constexpr double beyond = 1e-9;  // of the coordinates in a face: no gap between neighbours
constexpr double close = 1e-9;   // px, at which an iteration has converged
constexpr double margin = 1e-6;  // px, about a face's hull
constexpr int most_steps = 20;   // of Newton's iteration, which converges quadratically
constexpr double longest = 0.5;  // length of a step, in coordinates of the face
constexpr int divisions = 4;     // of a curved face's sides: a line of sight may meet it up to four times
constexpr std::ptrdiff_t chunk = 512;

struct Place {
  double r, s;
};

/// One coordinate of a face: one + r + s + r^2 + r s + s^2.
struct Polynomial {
  double one, r, s, rr, rs, ss;

  double at(Place p) const { return one + p.r * (r + p.r * rr + p.s * rs) + p.s * (s + p.s * ss); }
  double by_r(Place p) const { return r + 2 * p.r * rr + p.s * rs; }
  double by_s(Place p) const { return s + 2 * p.s * ss + p.r * rs; }
};

Polynomial polynomial(const Points& nodes, const Faces& faces, std::ptrdiff_t f, int d) {
  const double a = nodes(faces(f, 0), d), b = nodes(faces(f, 1), d), c = nodes(faces(f, 2), d);
  if (faces.cols() == 3) return {a, b - a, c - a, 0, 0, 0};
  const double ab = nodes(faces(f, 3), d), bc = nodes(faces(f, 4), d), ca = nodes(faces(f, 5), d);
  return {a,
          4 * ab - 3 * a - b,
          4 * ca - 3 * a - c,
          2 * (a + b) - 4 * ab,
          4 * (a + bc - ab - ca),
          2 * (a + c) - 4 * ca};
}

/// A face as polynomials of its coordinates: column, row, height.
struct FaceMap {
  Polynomial column, row, height;
};

std::vector<FaceMap> maps(const Points& nodes, const Faces& faces) {
  std::vector<FaceMap> found(static_cast<std::size_t>(faces.rows()));
  for (std::ptrdiff_t f = 0; f < faces.rows(); ++f) {
    found[static_cast<std::size_t>(f)] = {polynomial(nodes, faces, f, 0), polynomial(nodes, faces, f, 1),
                                          polynomial(nodes, faces, f, 2)};
  }
  return found;
}

/// Whether Newton's iteration from p ends at (x, y) inside the face, on a side that faces the camera.
bool iterate(const FaceMap& face, double x, double y, Place& p) {
  for (int step = 0; step < most_steps; ++step) {
    const double off_x = x - face.column.at(p), off_y = y - face.row.at(p);
    const double r_x = face.column.by_r(p), r_y = face.row.by_r(p);
    const double s_x = face.column.by_s(p), s_y = face.row.by_s(p);
    const double area = r_x * s_y - r_y * s_x;
    if (std::max(std::abs(off_x), std::abs(off_y)) < close) {
      return std::min({p.r, p.s, 1 - p.r - p.s}) >= -beyond && area < 0;  // rows count downwards
    }
    const double divisor = std::abs(area) > 1e-12 ? area : 1e-12;
    const double step_r = (off_x * s_y - off_y * s_x) / divisor;
    const double step_s = (r_x * off_y - r_y * off_x) / divisor;
    const double most = std::max({std::abs(step_r), std::abs(step_s), 1e-300});
    const double shorter = std::min(1.0, longest / most);
    p = {p.r + shorter * step_r, p.s + shorter * step_s};
    if (!std::isfinite(p.r + p.s)) return false;
  }
  return false;
}

/// Where iterations begin in a face.
std::vector<Place> starts(std::ptrdiff_t corners) {
  if (corners == 3) return {{1.0 / 3, 1.0 / 3}};
  std::vector<Place> found;
  for (int j = 0; j <= divisions; ++j)
    for (int i = 0; i + j <= divisions; ++i) found.push_back({i / double(divisions), j / double(divisions)});
  return found;
}

struct Box {
  double left, right, top, bottom;
  bool holds(double x, double y) const { return x >= left && x <= right && y >= top && y <= bottom; }
};

/// Of the Bezier points, in whose hull the face lies, with a margin.
Box hull(const Points& nodes, const Faces& faces, std::ptrdiff_t f) {
  Box box{};
  for (int d = 0; d < 2; ++d) {
    double low = std::numeric_limits<double>::infinity(), high = -low;
    const auto take = [&](double value) {
      low = std::min(low, value);
      high = std::max(high, value);
    };
    for (int k = 0; k < 3; ++k) {
      const double a = nodes(faces(f, k), d), b = nodes(faces(f, (k + 1) % 3), d);
      take(a);
      if (faces.cols() == 6) take(2 * nodes(faces(f, 3 + k), d) - 0.5 * (a + b));
    }
    (d == 0 ? box.left : box.top) = low - margin;
    (d == 0 ? box.right : box.bottom) = high + margin;
  }
  return box;
}

/// Which faces may be met at a position: their boxes in the squares of a grid.
class Grid {
 public:
  explicit Grid(std::vector<Box> boxes) : boxes_(std::move(boxes)) {
    constexpr double inf = std::numeric_limits<double>::infinity();
    all_ = {inf, -inf, inf, -inf};
    for (const Box& box : boxes_) {
      if (!finite(box)) continue;
      all_ = {std::min(all_.left, box.left), std::max(all_.right, box.right), std::min(all_.top, box.top),
              std::max(all_.bottom, box.bottom)};
    }
    side_ = std::max<std::ptrdiff_t>(1, static_cast<std::ptrdiff_t>(std::sqrt(double(boxes_.size()))));
    start_.assign(static_cast<std::size_t>(side_ * side_) + 1, 0);
    over_squares([&](std::size_t square, std::size_t) { ++start_[square + 1]; });
    for (std::size_t square = 1; square < start_.size(); ++square) start_[square] += start_[square - 1];
    listed_.resize(start_.back());
    std::vector<std::size_t> next(start_.begin(), start_.end() - 1);
    over_squares([&](std::size_t square, std::size_t f) { listed_[next[square]++] = f; });
  }

  /// Calls visit(f) for the faces whose boxes hold the position, in ascending order.
  template <typename Visit>
  void at(double x, double y, const Visit& visit) const {
    if (!all_.holds(x, y)) return;
    const auto square =
        static_cast<std::size_t>(line(y, all_.top, all_.bottom) * side_ + line(x, all_.left, all_.right));
    for (std::size_t k = start_[square]; k < start_[square + 1]; ++k)
      if (boxes_[listed_[k]].holds(x, y)) visit(listed_[k]);
  }

 private:
  static bool finite(const Box& box) {
    return std::isfinite(box.left + box.right) && std::isfinite(box.top + box.bottom);
  }

  /// Number of the line of squares in [0, side) at a position within [low, high]; it never falls with it.
  std::ptrdiff_t line(double position, double low, double high) const {
    const double share = (position - low) / (high - low);
    return std::min(side_ - 1, static_cast<std::ptrdiff_t>(share * static_cast<double>(side_)));
  }

  template <typename Visit>
  void over_squares(const Visit& visit) const {
    for (std::size_t f = 0; f < boxes_.size(); ++f) {
      const Box& box = boxes_[f];
      if (!finite(box)) continue;
      const auto left = line(box.left, all_.left, all_.right), right = line(box.right, all_.left, all_.right);
      const auto top = line(box.top, all_.top, all_.bottom), bottom = line(box.bottom, all_.top, all_.bottom);
      for (auto row = top; row <= bottom; ++row)
        for (auto column = left; column <= right; ++column)
          visit(static_cast<std::size_t>(row * side_ + column), f);
    }
  }

  std::vector<Box> boxes_;
  Box all_{};
  std::ptrdiff_t side_ = 1;
  std::vector<std::size_t> start_, listed_;
};

void check(const char* where, const Points& nodes, const Faces& faces) {
  require_size(where, "a face", faces.cols(), 3, 6);
  require_indices(where, "faces", faces, nodes.rows());
}

}  // namespace

FaceHits hits_near(const Points& nodes, const Faces& faces, const Indices& face, const Pairs& pixels,
                   const Pairs& start) {
  const char* const where = "hits_near";
  check(where, nodes, faces);
  require_indices(where, "face", face, faces.rows());
  require_size(where, "pixels", pixels.rows(), face.size());
  require_size(where, "start", start.rows(), face.size());
  const std::vector<FaceMap> mapped = maps(nodes, faces);
  FaceHits hits{face, start};
  for_chunks(face.size(), chunk, [&](std::ptrdiff_t begin, std::ptrdiff_t end, std::ptrdiff_t) {
    for (std::ptrdiff_t p = begin; p < end; ++p) {
      Place place{start(p, 0), start(p, 1)};
      if (iterate(mapped[static_cast<std::size_t>(face[p])], pixels(p, 0), pixels(p, 1), place)) {
        hits.place.row(p) << place.r, place.s;
      } else {
        hits.face[p] = -1;
      }
    }
  });
  return hits;
}

FaceHits first_hits(const Points& nodes, const Faces& faces, const Pairs& pixels) {
  check("first_hits", nodes, faces);
  const std::vector<FaceMap> mapped = maps(nodes, faces);
  std::vector<Box> boxes;
  for (std::ptrdiff_t f = 0; f < faces.rows(); ++f) boxes.push_back(hull(nodes, faces, f));
  const Grid grid(std::move(boxes));
  const std::vector<Place> begin_at = starts(faces.cols());
  FaceHits hits{Indices::Constant(pixels.rows(), -1), Pairs::Zero(pixels.rows(), 2)};
  for_chunks(pixels.rows(), chunk, [&](std::ptrdiff_t begin, std::ptrdiff_t end, std::ptrdiff_t) {
    for (std::ptrdiff_t p = begin; p < end; ++p) {
      double nearest = -std::numeric_limits<double>::infinity();
      grid.at(pixels(p, 0), pixels(p, 1), [&](std::size_t f) {
        for (Place place : begin_at) {
          if (!iterate(mapped[f], pixels(p, 0), pixels(p, 1), place)) continue;
          const double height = mapped[f].height.at(place);
          if (!(height >= nearest)) continue;
          nearest = height;
          hits.face[p] = static_cast<std::int32_t>(f);
          hits.place.row(p) << place.r, place.s;
        }
      });
    }
  });
  return hits;
}

}  // namespace plica::imaging
