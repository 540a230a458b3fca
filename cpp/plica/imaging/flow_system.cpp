#include "plica/imaging/flow_system.hpp"

#include "plica/core/require.hpp"
#include "plica/core/threads.hpp"
#include "plica/core/versions.hpp"

namespace plica::imaging {
namespace {

constexpr float clearly = 0.02F;  // product of two sides, each -1 to 1, blurred on coarse levels
constexpr float parted = 1e-3F;   // of the weight that is left, so that no pixel is without any

/// lambda w_S(b - a) of n pairs.
PLICA_INLINE void edge_weights_body(const float* a, const float* b, std::ptrdiff_t n, Weight weight, float lambda,
                                    float* __restrict__ result) {
  PLICA_INDEPENDENT
  for (std::ptrdiff_t x = 0; x < n; ++x) {
    const float d = b[x] - a[x];
    result[x] = lambda * weight(d * d);
  }
}
PLICA_VERSIONS(edge_weights,
               (const float* a, const float* b, std::ptrdiff_t n, Weight weight, float lambda, float* result),
               (a, b, n, weight, lambda, result))

/// Of n pairs: hardly anything between those on opposite sides.
void part(const float* a, const float* b, std::ptrdiff_t n, float* weight) {
  for (std::ptrdiff_t x = 0; x < n; ++x) {
    if (a[x] * b[x] < -clearly) weight[x] *= parted;
  }
}

/// trust w_D(e) of n pixels.
PLICA_INLINE void data_weights_body(const float* e, const float* trust, std::ptrdiff_t n, Weight weight,
                                    float* __restrict__ result) {
  PLICA_INDEPENDENT
  for (std::ptrdiff_t x = 0; x < n; ++x) result[x] = trust[x] * weight(e[x] * e[x]);
}
PLICA_VERSIONS(data_weights, (const float* e, const float* trust, std::ptrdiff_t n, Weight weight, float* result),
               (e, trust, n, weight, result))

/// One channel of the data term in a row, and the sums over channels it adds to: sum w_D (ix, iy)^T (ix, iy), its
/// determinant and the right-hand side.
struct Channel {
  const float *ix, *iy, *it, *weight, *u0, *v0;
  float *xx, *xy, *yy, *determinant, *b1, *b2;
};

PLICA_INLINE void add_body(const Channel& channel, std::ptrdiff_t n) {
  const float* const ix = channel.ix;
  const float* const iy = channel.iy;
  const float* const it = channel.it;
  const float* const weight = channel.weight;
  const float* const u0 = channel.u0;
  const float* const v0 = channel.v0;
  float* __restrict__ xx = channel.xx;
  float* __restrict__ xy = channel.xy;
  float* __restrict__ yy = channel.yy;
  float* __restrict__ determinant = channel.determinant;
  float* __restrict__ b1 = channel.b1;
  float* __restrict__ b2 = channel.b2;
  PLICA_INDEPENDENT
  for (std::ptrdiff_t x = 0; x < n; ++x) {
    const float wx = weight[x] * ix[x], wy = weight[x] * iy[x];
    const float e0 = ix[x] * u0[x] + iy[x] * v0[x] - it[x];
    const float grown = xx[x] * iy[x] * wy - 2 * xy[x] * ix[x] * wy + yy[x] * ix[x] * wx;
    determinant[x] += grown > 0 ? grown : 0.0F;
    xx[x] += wx * ix[x];
    xy[x] += wx * iy[x];
    yy[x] += wy * iy[x];
    b1[x] += wx * e0;
    b2[x] += wy * e0;
  }
}
PLICA_VERSIONS(add, (const Channel& channel, std::ptrdiff_t n), (channel, n))

/// The inverse of each pixel's 2 x 2 block in a row. Its determinant is a sum of terms that are not negative:
/// nothing cancels. With one channel the data's own is exactly 0.
struct Row {
  const float *xx, *xy, *yy, *determinant;
  const float *right_u, *down_u, *up_u, *right_v, *down_v, *up_v;  // right_*[-1] is the weight to the left
  float *inverse11, *inverse12, *inverse22;
};

PLICA_INLINE void blocks_body(const Row& row, std::ptrdiff_t n) {
  float* __restrict__ inverse11 = row.inverse11;
  float* __restrict__ inverse12 = row.inverse12;
  float* __restrict__ inverse22 = row.inverse22;
  PLICA_INDEPENDENT
  for (std::ptrdiff_t x = 0; x < n; ++x) {
    const float xx = row.xx[x], xy = row.xy[x], yy = row.yy[x];
    const float su = row.right_u[x] + row.right_u[x - 1] + row.down_u[x] + row.up_u[x];
    const float sv = row.right_v[x] + row.right_v[x - 1] + row.down_v[x] + row.up_v[x];
    const float scale = 1.0F / (xx * sv + yy * su + su * sv + row.determinant[x]);
    inverse11[x] = scale * (yy + sv);
    inverse12[x] = -scale * xy;
    inverse22[x] = scale * (xx + su);
  }
}
PLICA_VERSIONS(blocks, (const Row& row, std::ptrdiff_t n), (row, n))

/// Every second value of a row: n of them.
PLICA_INLINE void thin_body(const float* from, std::ptrdiff_t n, float* __restrict__ to) {
  PLICA_INDEPENDENT
  for (std::ptrdiff_t i = 0; i < n; ++i) to[i] = from[2 * i];
}
PLICA_VERSIONS(thin, (const float* from, std::ptrdiff_t n, float* to), (from, n, to))

/// To every second value of a row.
PLICA_INLINE void spread_body(const float* from, std::ptrdiff_t n, float* to) {
  for (std::ptrdiff_t i = 0; i < n; ++i) to[2 * i] = from[i];
}
PLICA_VERSIONS(spread, (const float* from, std::ptrdiff_t n, float* to), (from, n, to))

/// One colour's half of a row. left and right: of the other colour in the same row.
struct Half {
  float *u, *v;
  const float *b1, *b2, *inverse11, *inverse12, *inverse22;
  const float *left_u, *right_u, *up_u, *down_u, *left_v, *right_v, *up_v, *down_v;
  const float *to_left_u, *to_right_u, *to_up_u, *to_down_u, *to_left_v, *to_right_v, *to_up_v, *to_down_v;
};

PLICA_INLINE void relax_body(const Half& h, std::ptrdiff_t n, float relaxation) {
  float* __restrict__ u = h.u;
  float* __restrict__ v = h.v;
  const Half c = h;
  PLICA_INDEPENDENT
  for (std::ptrdiff_t i = 0; i < n; ++i) {
    const float su = c.b1[i] + (c.to_left_u[i] * c.left_u[i] + c.to_right_u[i] * c.right_u[i]) +
                     (c.to_up_u[i] * c.up_u[i] + c.to_down_u[i] * c.down_u[i]);
    const float sv = c.b2[i] + (c.to_left_v[i] * c.left_v[i] + c.to_right_v[i] * c.right_v[i]) +
                     (c.to_up_v[i] * c.up_v[i] + c.to_down_v[i] * c.down_v[i]);
    u[i] += relaxation * (c.inverse11[i] * su + c.inverse12[i] * sv - u[i]);
    v[i] += relaxation * (c.inverse12[i] * su + c.inverse22[i] * sv - v[i]);
  }
}
PLICA_VERSIONS(relax, (const Half& h, std::ptrdiff_t n, float relaxation), (h, n, relaxation))

}  // namespace

FlowSystem::FlowSystem(std::ptrdiff_t rows, std::ptrdiff_t columns)
    : rows_(rows), columns_(columns), half_((columns + 1) / 2), pitch_(half_ + 2) {
  require_at_least("FlowSystem", "rows", rows, 1);
  require_at_least("FlowSystem", "columns", columns, 1);
  const auto size = static_cast<std::size_t>((rows_ + 2) * pitch_);
  for (Colour& c : colours_) {
    for (auto* field : {&c.u, &c.v, &c.b1, &c.b2, &c.inverse11, &c.inverse12, &c.inverse22, &c.right_u, &c.down_u,
                        &c.right_v, &c.down_v}) {
      field->assign(size, 0.0F);
    }
  }
}

void FlowSystem::assemble(const std::vector<Linearisation>& channels, const Plane& u0, const Plane& v0,
                          Weight data_weight, Weight smooth_weight, float lambda, const Plane& sides) {
  const auto require = [&](const char* name, const Plane& plane) {
    require_size("FlowSystem", name, plane.rows(), rows_);
    require_size("FlowSystem", name, plane.cols(), columns_);
  };
  for (const Linearisation& channel : channels)
    for (const Plane* plane : {&channel.ix, &channel.iy, &channel.it, &channel.trust})
      require("a channel", *plane);
  for (const Plane* plane : {&u0, &v0}) require("the flow", *plane);
  if (sides.size() > 0) require("sides", sides);
  for_chunks(rows_, chunk_rows(columns_), [&](std::ptrdiff_t begin, std::ptrdiff_t end, std::ptrdiff_t) {
    const std::ptrdiff_t n = columns_;
    // right_* have an entry before the first: the weight to the left of pixel 0 is 0.
    std::vector<float> right_u(static_cast<std::size_t>(n + 1)), right_v(right_u), up_u(right_u), up_v(right_u),
        down_u(right_u), down_v(right_u), weight(right_u), xx(right_u), xy(right_u), yy(right_u),
        determinant(right_u), b1(right_u), b2(right_u), i11(right_u), i12(right_u), i22(right_u);
    const auto line = [&](const Plane& plane, std::ptrdiff_t y) { return plane.data() + y * n; };
    const auto below = [&](std::ptrdiff_t y, std::vector<float>& to_u, std::vector<float>& to_v) {
      if (y < 0 || y + 1 >= rows_) {
        std::fill(to_u.begin(), to_u.end(), 0.0F);
        std::fill(to_v.begin(), to_v.end(), 0.0F);
        return;
      }
      edge_weights(line(u0, y), line(u0, y + 1), n, smooth_weight, lambda, to_u.data());
      edge_weights(line(v0, y), line(v0, y + 1), n, smooth_weight, lambda, to_v.data());
      if (sides.size() == 0) return;
      part(line(sides, y), line(sides, y + 1), n, to_u.data());
      part(line(sides, y), line(sides, y + 1), n, to_v.data());
    };
    below(begin - 1, down_u, down_v);
    for (std::ptrdiff_t y = begin; y < end; ++y) {
      std::swap(up_u, down_u);
      std::swap(up_v, down_v);
      below(y, down_u, down_v);
      edge_weights(line(u0, y), line(u0, y) + 1, n - 1, smooth_weight, lambda, right_u.data() + 1);
      edge_weights(line(v0, y), line(v0, y) + 1, n - 1, smooth_weight, lambda, right_v.data() + 1);
      if (sides.size() > 0) {
        part(line(sides, y), line(sides, y) + 1, n - 1, right_u.data() + 1);
        part(line(sides, y), line(sides, y) + 1, n - 1, right_v.data() + 1);
      }
      right_u.back() = right_v.back() = 0;
      for (auto* sum : {&xx, &xy, &yy, &determinant, &b1, &b2}) std::fill(sum->begin(), sum->end(), 0.0F);
      for (const Linearisation& channel : channels) {
        data_weights(line(channel.it, y), line(channel.trust, y), n, data_weight, weight.data());
        add({line(channel.ix, y), line(channel.iy, y), line(channel.it, y), weight.data(), line(u0, y),
             line(v0, y), xx.data(), xy.data(), yy.data(), determinant.data(), b1.data(), b2.data()},
            n);
      }
      blocks({xx.data(), xy.data(), yy.data(), determinant.data(), right_u.data() + 1, down_u.data(), up_u.data(),
              right_v.data() + 1, down_v.data(), up_v.data(), i11.data(), i12.data(), i22.data()},
             n);
      for (int colour = 0; colour < 2; ++colour) {
        Colour& c = colours_[static_cast<std::size_t>(colour)];
        const std::ptrdiff_t start = (y + colour) % 2, count = (n - start + 1) / 2, to = at(y, 0);
        thin(line(u0, y) + start, count, c.u.data() + to);
        thin(line(v0, y) + start, count, c.v.data() + to);
        thin(b1.data() + start, count, c.b1.data() + to);
        thin(b2.data() + start, count, c.b2.data() + to);
        thin(i11.data() + start, count, c.inverse11.data() + to);
        thin(i12.data() + start, count, c.inverse12.data() + to);
        thin(i22.data() + start, count, c.inverse22.data() + to);
        thin(right_u.data() + 1 + start, count, c.right_u.data() + to);
        thin(down_u.data() + start, count, c.down_u.data() + to);
        thin(right_v.data() + 1 + start, count, c.right_v.data() + to);
        thin(down_v.data() + start, count, c.down_v.data() + to);
      }
    }
  });
}

void FlowSystem::sweep(int count, float relaxation) {
  const auto of = [](const std::vector<float>& field, std::ptrdiff_t k) { return field.data() + k; };
  for (int half_sweep = 0; half_sweep < 2 * count; ++half_sweep) {
    const std::ptrdiff_t colour = half_sweep % 2;
    Colour& own = colours_[static_cast<std::size_t>(colour)];
    const Colour& other = colours_[static_cast<std::size_t>(1 - colour)];
    for_chunks(rows_, chunk_rows(columns_), [&](std::ptrdiff_t begin, std::ptrdiff_t end, std::ptrdiff_t) {
      for (std::ptrdiff_t y = begin; y < end; ++y) {
        const std::ptrdiff_t i = at(y, 0), right = i + (y + colour) % 2, left = right - 1, up = i - pitch_,
                             down = i + pitch_;
        relax({own.u.data() + i,     own.v.data() + i,     of(own.b1, i),        of(own.b2, i),
               of(own.inverse11, i), of(own.inverse12, i), of(own.inverse22, i), of(other.u, left),
               of(other.u, right),   of(other.u, up),      of(other.u, down),    of(other.v, left),
               of(other.v, right),   of(other.v, up),      of(other.v, down),    of(other.right_u, left),
               of(own.right_u, i),   of(other.down_u, up), of(own.down_u, i),    of(other.right_v, left),
               of(own.right_v, i),   of(other.down_v, up), of(own.down_v, i)},
              half_, relaxation);
      }
    });
  }
}

void FlowSystem::read(Plane& u, Plane& v) const {
  u.resize(rows_, columns_);
  v.resize(rows_, columns_);
  for_chunks(rows_, chunk_rows(columns_), [&](std::ptrdiff_t begin, std::ptrdiff_t end, std::ptrdiff_t) {
    for (std::ptrdiff_t y = begin; y < end; ++y) {
      for (int colour = 0; colour < 2; ++colour) {
        const Colour& c = colours_[static_cast<std::size_t>(colour)];
        const std::ptrdiff_t start = (y + colour) % 2, count = (columns_ - start + 1) / 2;
        spread(c.u.data() + at(y, 0), count, &u(y, 0) + start);
        spread(c.v.data() + at(y, 0), count, &v(y, 0) + start);
      }
    }
  });
}

}  // namespace plica::imaging
