#include "plica/mesh/triangulation.hpp"

#include <algorithm>
#include <cmath>
#include <deque>
#include <limits>
#include <set>

#include "plica/core/error.hpp"

namespace plica {

namespace {

using Point = Eigen::Vector2d;
using Corners = std::array<std::int32_t, 3>;

/// Twice the signed area of a b c.
double turn(const Point& a, const Point& b, const Point& c) {
  return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

/// > 0 where d lies within the circle through a, b, c (counter-clockwise), by more than roundoff.
bool in_circle(const Point& a, const Point& b, const Point& c, const Point& d) {
  const Point p = a - d, q = b - d, r = c - d;
  const double pp = p.squaredNorm(), qq = q.squaredNorm(), rr = r.squaredNorm();
  const double value =
      p[0] * (q[1] * rr - r[1] * qq) - p[1] * (q[0] * rr - r[0] * qq) + pp * (q[0] * r[1] - r[0] * q[1]);
  const double largest = std::max({pp, qq, rr});
  return value > 1e-12 * largest * largest;
}

Point circumcentre(const Point& a, const Point& b, const Point& c) {
  const Point u = b - a, v = c - a;
  const double twice = 2 * (u[0] * v[1] - u[1] * v[0]);
  return a +
         Point(v[1] * u.squaredNorm() - u[1] * v.squaredNorm(), u[0] * v.squaredNorm() - v[0] * u.squaredNorm()) /
             twice;
}

double distance(const Point& p, const Point& a, const Point& b) {
  const Point along = b - a;
  const double t = std::clamp((p - a).dot(along) / along.squaredNorm(), 0.0, 1.0);
  return (p - a - t * along).norm();
}

class Builder {
 public:
  explicit Builder(const Outline& outline) : outline_(outline), points_(outline.points) {
    for (const auto& line : outline.lines)
      for (std::size_t i = 0; i + 1 < line.size(); ++i) fixed_.insert(edge(line[i], line[i + 1]));
    frame();
    for (std::int32_t p = 0; p < own_; ++p) insert(p);
    for (const auto& [a, b] : fixed_) recover(a, b);
    settle();
    remove_outside();
    refine();
    for (int pass = 0; pass < 8; ++pass) relax();
  }

  Triangulation result() const {
    Triangulation made{points_, triangles_};
    made.points.erase(made.points.begin() + own_, made.points.begin() + own_ + 4);
    for (auto& triangle : made.triangles)
      for (auto& node : triangle)
        if (node >= own_) node -= 4;
    return made;
  }

 private:
  /// Four points far around, after the outline's, and two triangles of them.
  void frame() {
    own_ = static_cast<std::int32_t>(points_.size());
    Point low = points_[0], high = points_[0];
    for (const Point& p : points_) low = low.cwiseMin(p), high = high.cwiseMax(p);
    const double far = 4 * (high - low).maxCoeff();
    const Point middle = 0.5 * (low + high);
    for (const Point& corner : {Point(-far, -far), Point(far, -far), Point(far, far), Point(-far, far)})
      points_.push_back(middle + corner);
    triangles_ = {{own_, own_ + 1, own_ + 2}, {own_, own_ + 2, own_ + 3}};
  }

  /// The triangle with that directed edge, turned so that the edge comes first.
  bool with_edge(std::int32_t a, std::int32_t b, std::size_t& place, Corners& turned) const {
    for (place = 0; place < triangles_.size(); ++place) {
      const Corners& t = triangles_[place];
      for (int k = 0; k < 3; ++k)
        if (t[k] == a && t[(k + 1) % 3] == b) {
          turned = {a, b, t[(k + 2) % 3]};
          return true;
        }
    }
    return false;
  }

  /// Exchanges the diagonal a b of two triangles a b c, b a d where that leaves both positive.
  bool flip(std::int32_t a, std::int32_t b) {
    std::size_t first, second;
    Corners t, u;
    if (!with_edge(a, b, first, t) || !with_edge(b, a, second, u)) return false;
    const std::int32_t c = t[2], d = u[2];
    if (!positive(c, a, d) || !positive(d, b, c)) return false;
    triangles_[first] = {c, a, d};
    triangles_[second] = {d, b, c};
    return true;
  }

  bool on_a_line(const Corners& t) const {
    for (const auto& line : outline_.lines)
      if (std::all_of(t.begin(), t.end(),
                      [&](auto p) { return std::find(line.begin(), line.end(), p) != line.end(); }))
        return true;
    return false;
  }

  bool positive(std::int32_t a, std::int32_t b, std::int32_t c) const {
    const Point &p = points_[a], &q = points_[b], &r = points_[c];
    return turn(p, q, r) > 1e-12 * std::max((q - p).squaredNorm(), (r - p).squaredNorm());
  }

  /// Lawson's flips from these edges on, until each is fixed or Delaunay.
  void legalise(std::vector<Edge> edges) {
    while (!edges.empty()) {
      const Edge e = edges.back();
      edges.pop_back();
      if (fixed_.count(e)) continue;
      std::size_t place;
      Corners t, u;
      if (!with_edge(e[0], e[1], place, t) || !with_edge(e[1], e[0], place, u)) continue;
      const bool bad = on_a_line(t) || on_a_line(u),
                 would_be_bad = on_a_line({t[2], u[2], t[0]}) || on_a_line({t[2], u[2], t[1]});
      const bool wanted =
          bad != would_be_bad ? bad : in_circle(points_[t[0]], points_[t[1]], points_[t[2]], points_[u[2]]);
      if (!wanted || !flip(e[0], e[1])) continue;
      for (const std::int32_t end : e)
        for (const std::int32_t tip : {t[2], u[2]}) edges.push_back(edge(end, tip));
    }
  }

  void settle() {
    std::set<Edge> all;
    for (const Corners& t : triangles_)
      for (int k = 0; k < 3; ++k) all.insert(edge(t[k], t[(k + 1) % 3]));
    legalise({all.begin(), all.end()});
  }

  /// Joins a point to the corners of the triangle, or of both triangles at the edge, that it lies in.
  bool insert(std::int32_t p) {
    const Point x = points_[p];
    for (std::size_t place = 0; place < triangles_.size(); ++place) {
      const Corners t = triangles_[place];
      std::array<double, 3> area;
      for (int k = 0; k < 3; ++k) {
        const Point &a = points_[t[k]], &b = points_[t[(k + 1) % 3]];
        area[k] = turn(a, b, x) / (b - a).squaredNorm();  // height over length
      }
      const auto low = std::min_element(area.begin(), area.end()) - area.begin();
      if (area[low] < -1e-10) continue;
      const std::int32_t a = t[low], b = t[(low + 1) % 3], c = t[(low + 2) % 3];
      std::size_t beside;
      Corners u;
      if (area[low] <= 1e-10) {
        if (!with_edge(b, a, beside, u)) return false;
        triangles_[place] = {b, c, p};
        triangles_.push_back({c, a, p});
        triangles_[beside] = {a, u[2], p};
        triangles_.push_back({u[2], b, p});
        legalise({edge(b, c), edge(c, a), edge(a, u[2]), edge(u[2], b)});
      } else {
        triangles_[place] = {a, b, p};
        triangles_.push_back({b, c, p});
        triangles_.push_back({c, a, p});
        legalise({edge(a, b), edge(b, c), edge(c, a)});
      }
      return true;
    }
    return false;
  }

  /// Makes a b an edge by flipping the edges that cross it (Sloan 1993).
  void recover(std::int32_t a, std::int32_t b) {
    const auto crosses = [&](const Edge& e) {
      if (e[0] == a || e[0] == b || e[1] == a || e[1] == b) return false;
      const Point &p = points_[a], &q = points_[b], &r = points_[e[0]], &s = points_[e[1]];
      return turn(p, q, r) * turn(p, q, s) < 0 && turn(r, s, p) * turn(r, s, q) < 0;
    };
    std::set<Edge> all;
    for (const Corners& t : triangles_)
      for (int k = 0; k < 3; ++k) all.insert(edge(t[k], t[(k + 1) % 3]));
    if (all.count(edge(a, b))) return;
    std::deque<Edge> crossing;
    for (const Edge& e : all)
      if (crosses(e)) crossing.push_back(e);
    for (std::size_t tries = 0; !crossing.empty(); ++tries) {
      if (tries > 100 * points_.size() || fixed_.count(crossing.front()))
        throw InvalidInput("triangulate: two segments of an outline cross, or run through a point.");
      const Edge e = crossing.front();
      crossing.pop_front();
      std::size_t place;
      Corners t, u;
      if (!with_edge(e[0], e[1], place, t) || !with_edge(e[1], e[0], place, u)) continue;
      if (!flip(e[0], e[1])) {
        crossing.push_back(e);
      } else if (const Edge made = edge(t[2], u[2]); crosses(made)) {
        crossing.push_back(made);
      }
    }
    std::size_t place;
    Corners t;
    if (!with_edge(a, b, place, t) && !with_edge(b, a, place, t))
      throw InvalidInput("triangulate: a segment of an outline runs through a point.");
  }

  void remove_outside() {
    const auto outside = [&](const Corners& t) {
      for (const auto node : t)
        if (node >= own_ && node < own_ + 4) return true;
      return !outline_.inside((points_[t[0]] + points_[t[1]] + points_[t[2]]) / 3);
    };
    triangles_.erase(std::remove_if(triangles_.begin(), triangles_.end(), outside), triangles_.end());
  }

  /// Circumcentres of the triangles largest for their place come first; one too near a point or a segment is left
  /// out.
  void refine() {
    std::set<Corners> left;
    for (;;) {
      double most = 1;
      Corners worst{};
      Point where;
      for (const Corners& t : triangles_) {
        if (left.count(t)) continue;
        const Point centre = circumcentre(points_[t[0]], points_[t[1]], points_[t[2]]);
        // The circumradius of an equilateral triangle of edge h is h / sqrt(3).
        const Point within = (points_[t[0]] + points_[t[1]] + points_[t[2]]) / 3;
        const double ratio = (points_[t[0]] - centre).norm() * std::sqrt(3.0) / outline_.size(within);
        if (ratio > most) most = ratio, worst = t, where = centre;
      }
      if (most <= 1) return;
      left.insert(worst);
      if (!roomy(where)) continue;
      points_.push_back(where);
      if (!insert(static_cast<std::int32_t>(points_.size()) - 1)) points_.pop_back();
    }
  }

  bool roomy(const Point& p) const {
    if (!outline_.inside(p)) return false;
    const double room = outline_.size(p);
    for (const Point& q : points_)
      if ((p - q).norm() < 0.65 * room) return false;
    for (const auto& [a, b] : fixed_)
      if (distance(p, points_[a], points_[b]) < 0.45 * room) return false;
    return true;
  }

  /// Moves each added point to the middle of its neighbours where no triangle of it gets worse than the worst was.
  void relax() {
    const auto quality = [&](const Corners& t) {  // 1 where equilateral
      const Point &a = points_[t[0]], &b = points_[t[1]], &c = points_[t[2]];
      return turn(a, b, c) / ((b - a).squaredNorm() + (c - b).squaredNorm() + (a - c).squaredNorm());
    };
    for (auto p = own_ + 4; p < static_cast<std::int32_t>(points_.size()); ++p) {
      Point sum = Point::Zero();
      double weight = 0;
      std::vector<Corners> own;
      for (const Corners& t : triangles_)
        if (std::find(t.begin(), t.end(), p) != t.end()) {
          own.push_back(t);
          for (const auto node : t)
            if (node != p) sum += points_[node], weight += 1;
        }
      const auto worst = [&] {
        double least = std::numeric_limits<double>::infinity();
        for (const Corners& t : own) least = std::min(least, quality(t));
        return least;
      };
      if (own.empty()) continue;
      const double before = worst();
      const Point old = points_[p];
      points_[p] = sum / weight;
      if (worst() < before) points_[p] = old;
    }
    settle();
  }

  const Outline& outline_;
  std::vector<Point> points_;  // the outline's, the frame's four, the added
  std::vector<Corners> triangles_;
  std::set<Edge> fixed_;
  std::int32_t own_ = 0;
};

}  // namespace

Triangulation triangulate(const Outline& outline) { return Builder(outline).result(); }

}  // namespace plica
