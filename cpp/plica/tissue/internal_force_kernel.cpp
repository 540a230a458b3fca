#include "plica/tissue/internal_force_kernel.hpp"

#include <cmath>
#include <limits>

#include "plica/core/registers.hpp"
#include "plica/core/versions.hpp"
#include "plica/tissue/element.hpp"

namespace plica {
namespace {

using Batch = InternalForce::Batch;
using Map = InternalForce::Map;
using Input = InternalForceInput;
constexpr int lanes = InternalForce::lanes;
constexpr int between[4][4] = {{0, 4, 6, 7}, {4, 1, 5, 8}, {6, 5, 2, 9}, {7, 8, 9, 3}};  // node between corners

/// Of the points where a cell is looked at, by weights of the field's corners: one where it is the same all over.
const TetrahedronRule& rule_of(int corners) {
  static const TetrahedronRule middle{{{1.0, 0.0, 0.0, 0.0}, 1.0}};
  return corners == 1 ? middle : tetrahedron_rule_degree_5();
}

template <typename Width>
PLICA_INLINE const typename Width::Register& load(const double* at) {
  return *reinterpret_cast<const typename Width::Register*>(at);
}

/// Rows of a matrix one after the other.
template <typename Width>
struct Matrix {
  typename Width::Register at[9];
};

/// A B, and A B^T.
template <typename Width>
PLICA_INLINE void multiply(const typename Width::Register* a, const typename Width::Register* b,
                           typename Width::Register* out) {
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      out[3 * i + j] = a[3 * i] * b[j] + a[3 * i + 1] * b[3 + j] + a[3 * i + 2] * b[6 + j];
}
template <typename Width>
PLICA_INLINE void multiply_transposed(const typename Width::Register* a, const typename Width::Register* b,
                                      typename Width::Register* out) {
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      out[3 * i + j] = a[3 * i] * b[3 * j] + a[3 * i + 1] * b[3 * j + 1] + a[3 * i + 2] * b[3 * j + 2];
}

/// d/dxi_k of a nodal field at each corner, [component][k]: in a quadratic cell it is linear between them. At
/// corner i d/dl_i = 3 u_i and d/dl_k = 4 u_ik - u_k.
template <typename Width>
PLICA_INLINE void slopes_at_corners(const Batch& batch, const double* u, const double* offset, int corners,
                                    int from, Matrix<Width>* slope) {
  typedef typename Width::Register Register;
  constexpr int width = sizeof(Register) / sizeof(double);
  const int nodes = corners == 1 ? 4 : 10;
  for (int c = 0; c < 3; ++c) {
    Register at[10];
    for (int a = 0; a < nodes; ++a)
      for (int lane = 0; lane < width; ++lane) {
        const std::ptrdiff_t k = 3 * static_cast<std::ptrdiff_t>(batch.node[a][from + lane]) + c;
        at[a][lane] = offset ? u[k] + offset[k] : u[k];
      }
    if (corners == 1) {
      for (int k = 0; k < 3; ++k) slope[0].at[3 * c + k] = at[k + 1] - at[0];
      continue;
    }
    for (int i = 0; i < 4; ++i) {
      Register by[4];
      for (int k = 0; k < 4; ++k) by[k] = k == i ? 3.0 * at[i] : 4.0 * at[between[i][k]] - at[k];
      for (int k = 0; k < 3; ++k) slope[i].at[3 * c + k] = by[k + 1] - by[0];
    }
  }
}

/// The transpose: adds to the nodes' forces what the moments of a field of stress at the corners are.
template <typename Width>
PLICA_INLINE void add_corner_forces(const Matrix<Width>* moment, int corners, int from, double* out) {
  typedef typename Width::Register Register;
  for (int c = 0; c < 3; ++c) {
    Register at[10] = {};
    if (corners == 1) {
      for (int k = 0; k < 3; ++k) {
        at[k + 1] = moment[0].at[3 * c + k];
        at[0] -= at[k + 1];
      }
    } else {
      for (int i = 0; i < 4; ++i) {
        Register by[4];
        for (int k = 0; k < 3; ++k) by[k + 1] = moment[i].at[3 * c + k];
        by[0] = -(by[1] + by[2] + by[3]);
        for (int k = 0; k < 4; ++k) {
          if (k == i) {
            at[i] += 3.0 * by[k];
          } else {
            at[k] -= by[k];
            at[between[i][k]] += 4.0 * by[k];
          }
        }
      }
    }
    for (int a = 0; a < (corners == 1 ? 4 : 10); ++a)
      *reinterpret_cast<Register*>(out + lanes * (3 * a + c) + from) = at[a];
  }
}

/// The field at a point from that at the corners.
template <typename Width>
PLICA_INLINE void interpolate(const Matrix<Width>* corner, const double* weight, int corners,
                              typename Width::Register* out) {
  for (int k = 0; k < 9; ++k) {
    out[k] = weight[0] * corner[0].at[k];
    for (int i = 1; i < corners; ++i) out[k] += weight[i] * corner[i].at[k];
  }
}

/// The strain at a point whose displacement has the gradient G.
template <typename Width>
struct Strain {
  typedef typename Width::Register Register;
  Register E[9], pulled[3], q, change, higher, volume;  // J - 1, what of it is not linear in G, ln J

  PLICA_INLINE Strain(const Register* G, const Register* a) {
    for (int i = 0; i < 3; ++i)
      for (int j = i; j < 3; ++j)
        E[3 * i + j] = E[3 * j + i] =
            0.5 * (G[3 * i + j] + G[3 * j + i] + G[i] * G[j] + G[3 + i] * G[3 + j] + G[6 + i] * G[6 + j]);
    for (int i = 0; i < 3; ++i) pulled[i] = E[3 * i] * a[0] + E[3 * i + 1] * a[1] + E[3 * i + 2] * a[2];
    q = a[0] * pulled[0] + a[1] * pulled[1] + a[2] * pulled[2];
    const Register minors = G[0] * G[4] - G[1] * G[3] + G[4] * G[8] - G[5] * G[7] + G[8] * G[0] - G[6] * G[2];
    const Register det = G[0] * (G[4] * G[8] - G[5] * G[7]) - G[1] * (G[3] * G[8] - G[5] * G[6]) +
                         G[2] * (G[3] * G[7] - G[4] * G[6]);
    higher = minors + det;
    change = G[0] + G[4] + G[8] + higher;
    volume = change;
    for (int lane = 0; lane < static_cast<int>(sizeof(Register) / sizeof(double)); ++lane)
      volume[lane] = change[lane] > -1 ? std::log1p(change[lane]) : std::numeric_limits<double>::quiet_NaN();
  }
};

/// x - ln(1 + x) of small x, as a series in t = x / (2 + x): ln(1 + x) = 2 (t + t^3 / 3 + ...).
inline double above_logarithm(double x) {
  const double t = x / (2 + x), s = t * t;
  return x * t - 2 * t * s * (1.0 / 3 + s * (1.0 / 5 + s * (1.0 / 7 + s * (1.0 / 9 + s * (1.0 / 11 + s / 13)))));
}

/// w = tr E - ln J, whose first order cancels: tr E = tr G + |G|^2 / 2, J - 1 = tr G + its higher terms.
template <typename Width>
PLICA_INLINE typename Width::Register change_of_shape(const typename Width::Register* G, const Strain<Width>& at) {
  typedef typename Width::Register Register;
  Register shape = at.change - at.volume - at.higher;
  for (int k = 0; k < 9; ++k) shape += 0.5 * G[k] * G[k];
  for (int lane = 0; lane < static_cast<int>(sizeof(Register) / sizeof(double)); ++lane)
    if (std::abs(at.change[lane]) < 0.1)
      shape[lane] += above_logarithm(at.change[lane]) - (at.change[lane] - at.volume[lane]);
  return shape;
}

/// Adds what stiffening does to the tension along the fibre, or to the energy, and what the active stress does.
template <typename Width, bool energy>
PLICA_INLINE void add_fibre_extra(const Batch& batch, int from, const typename Width::Register& q,
                                  typename Width::Register& sum) {
  typedef typename Width::Register Register;
  for (int lane = 0; lane < static_cast<int>(sizeof(Register) / sizeof(double)); ++lane) {
    const double modulus = batch.law[5][from + lane], four_k = batch.law[6][from + lane];
    const double active = batch.law[7][from + lane], own = q[lane];
    if (four_k > 0 && own > 0) {
      const double more = std::expm1(four_k * own * own);
      sum[lane] += modulus * (energy ? more / (2 * four_k) - 0.5 * own * own : own * more);
    }
    if (active != 0) {
      const double stretch = std::sqrt(1 + 2 * own);
      sum[lane] += energy ? active * (stretch - 1) : active / stretch;
    }
  }
}

/// P_e (docs/theory/finite_strain.md): F^-T (2 mu E + p 1) + F a (t a + s E a) + s F E a a, each part of it zero
/// at rest, so that small strains keep their digits.
template <typename Width>
PLICA_INLINE void elastic_stress(const Batch& batch, int from, const Strain<Width>& at,
                                 const typename Width::Register* G, const typename Width::Register* F,
                                 const typename Width::Register* turned, const typename Width::Register* a,
                                 typename Width::Register* P) {
  typedef typename Width::Register Register;
  Register mu = load<Width>(batch.law[0] + from);
  if (batch.matrix_stiffens) mu *= 1.0 + load<Width>(batch.law[8] + from) * change_of_shape<Width>(G, at);
  const Register shear = load<Width>(batch.law[3] + from);
  const Register lambda = load<Width>(batch.law[1] + from);
  const Register two_beta = 2.0 * load<Width>(batch.law[2] + from);
  Register tension = two_beta * at.volume + load<Width>(batch.law[4] + from) * at.q;
  if (batch.stiffens || batch.pulls) add_fibre_extra<Width, false>(batch, from, at.q, tension);
  const Register pressure = lambda * at.volume + two_beta * at.q;
  Register T[9];
  for (int k = 0; k < 9; ++k) T[k] = 2.0 * mu * at.E[k];
  for (int k = 0; k < 9; k += 4) T[k] += pressure;
  multiply<Width>(turned, T, P);
  for (int i = 0; i < 3; ++i) {
    const Register along = F[3 * i] * a[0] + F[3 * i + 1] * a[1] + F[3 * i + 2] * a[2];
    const Register across =
        shear * (F[3 * i] * at.pulled[0] + F[3 * i + 1] * at.pulled[1] + F[3 * i + 2] * at.pulled[2]);
    for (int j = 0; j < 3; ++j) P[3 * i + j] += along * (tension * a[j] + shear * at.pulled[j]) + across * a[j];
  }
}

template <typename Width>
PLICA_INLINE void force_body(const Batch& batch, const Map* maps, const Input& input, double* elastic,
                             double* viscous, double* least) {
  typedef typename Width::Register Register;
  constexpr int width = sizeof(Register) / sizeof(double);
  const TetrahedronRule& rule = rule_of(input.corners);
  const int corners = input.corners;
  for (int from = 0; from < lanes; from += width) {
    Matrix<Width> slope[4], rate[4], moment[4] = {}, moment_viscous[4] = {};
    slopes_at_corners(batch, input.u, input.offset, corners, from, slope);
    if (viscous) slopes_at_corners(batch, input.v, nullptr, corners, from, rate);
    Register a[3], inverse[9], smallest = {}, sum = {};
    for (int k = 0; k < 3; ++k) a[k] = load<Width>(batch.law[10 + k] + from);
    for (int lane = 0; lane < width; ++lane) smallest[lane] = std::numeric_limits<double>::infinity();
    const Register eta = load<Width>(batch.law[9] + from);
    for (std::size_t p = 0; p < rule.size(); ++p) {
      const Map& map = maps[batch.curved ? p : 0];
      if (p == 0 || batch.curved)
        for (int k = 0; k < 9; ++k) inverse[k] = load<Width>(map.inverse[k] + from);
      Register by_xi[9], G[9], F[9], turned[9], P[9];
      interpolate<Width>(slope, rule[p].at.data(), corners, by_xi);
      multiply<Width>(by_xi, inverse, G);
      for (int k = 0; k < 9; ++k) F[k] = k % 4 == 0 ? 1.0 + G[k] : G[k];
      const Strain<Width> at(G, a);
      const Register J = 1.0 + at.change, over = 1.0 / J;
      for (int i = 0; i < 3; ++i)  // F^-T, its cofactors over J
        for (int j = 0; j < 3; ++j) {
          const int i1 = (i + 1) % 3, i2 = (i + 2) % 3, j1 = (j + 1) % 3, j2 = (j + 2) % 3;
          turned[3 * i + j] = (F[3 * i1 + j1] * F[3 * i2 + j2] - F[3 * i1 + j2] * F[3 * i2 + j1]) * over;
        }
      elastic_stress(batch, from, at, G, F, turned, a, P);
      for (int lane = 0; lane < width; ++lane)
        smallest[lane] = J[lane] < smallest[lane] ? J[lane] : smallest[lane];
      for (int k = 0; k < 9; ++k) sum += P[k];
      const Register volume = load<Width>(map.volume + from) * rule[p].weight;
      Register by_node[9];
      multiply_transposed<Width>(P, inverse, by_node);  // P grad xi_k
      for (int i = 0; i < corners; ++i) {
        const Register share = volume * rule[p].at[static_cast<std::size_t>(i)];
        for (int k = 0; k < 9; ++k) moment[i].at[k] += share * by_node[k];
      }
      if (!viscous) continue;
      Register R[9], L[9], d[9];
      interpolate<Width>(rate, rule[p].at.data(), corners, by_xi);
      multiply<Width>(by_xi, inverse, R);
      multiply_transposed<Width>(R, turned, L);  // dv/dx = dv/dX F^-1
      const Register weighted = eta * J;
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) d[3 * i + j] = 0.5 * weighted * (L[3 * i + j] + L[3 * j + i]);
      multiply<Width>(d, turned, P);
      for (int k = 0; k < 9; ++k) sum += P[k];
      multiply_transposed<Width>(P, inverse, by_node);
      for (int i = 0; i < corners; ++i) {
        const Register share = volume * rule[p].at[static_cast<std::size_t>(i)];
        for (int k = 0; k < 9; ++k) moment_viscous[i].at[k] += share * by_node[k];
      }
    }
    add_corner_forces(moment, corners, from, elastic);
    if (viscous) add_corner_forces(moment_viscous, corners, from, viscous);
    const Register checked = smallest + 0.0 * sum;  // NaN where a stress is not finite
    for (int lane = 0; lane < width; ++lane) least[from + lane] = checked[lane];
  }
}

template <typename Width>
PLICA_INLINE void energy_body(const Batch& batch, const Map* maps, const Input& input, double* energy) {
  typedef typename Width::Register Register;
  constexpr int width = sizeof(Register) / sizeof(double);
  const TetrahedronRule& rule = rule_of(input.corners);
  for (int from = 0; from < lanes; from += width) {
    Matrix<Width> slope[4];
    slopes_at_corners(batch, input.u, input.offset, input.corners, from, slope);
    Register a[3], inverse[9], whole = {};
    for (int k = 0; k < 3; ++k) a[k] = load<Width>(batch.law[10 + k] + from);
    for (std::size_t p = 0; p < rule.size(); ++p) {
      const Map& map = maps[batch.curved ? p : 0];
      if (p == 0 || batch.curved)
        for (int k = 0; k < 9; ++k) inverse[k] = load<Width>(map.inverse[k] + from);
      Register by_xi[9], G[9];
      interpolate<Width>(slope, rule[p].at.data(), input.corners, by_xi);
      multiply<Width>(by_xi, inverse, G);
      const Strain<Width> at(G, a);
      Register shape = change_of_shape<Width>(G, at), squares = {};
      if (batch.matrix_stiffens) shape *= 1.0 + 0.5 * load<Width>(batch.law[8] + from) * shape;
      for (int k = 0; k < 3; ++k) squares += at.pulled[k] * at.pulled[k];
      Register W = load<Width>(batch.law[0] + from) * shape +
                   0.5 * load<Width>(batch.law[1] + from) * at.volume * at.volume +
                   2.0 * load<Width>(batch.law[2] + from) * at.q * at.volume +
                   load<Width>(batch.law[3] + from) * squares +
                   0.5 * load<Width>(batch.law[4] + from) * at.q * at.q;
      if (batch.stiffens || batch.pulls) add_fibre_extra<Width, true>(batch, from, at.q, W);
      whole += load<Width>(map.volume + from) * rule[p].weight * W;
    }
    for (int lane = 0; lane < width; ++lane) energy[from + lane] = whole[lane];
  }
}

#define PLICA_INTERNAL_FORCE(suffix, Width, target)                                                      \
  target void force_##suffix(const Batch& batch, const Map* maps, const Input& input, double* elastic,   \
                             double* viscous, double* least) {                                           \
    force_body<Width>(batch, maps, input, elastic, viscous, least);                                      \
  }                                                                                                      \
  target void energy_##suffix(const Batch& batch, const Map* maps, const Input& input, double* energy) { \
    energy_body<Width>(batch, maps, input, energy);                                                      \
  }                                                                                                      \
  constexpr InternalForceKernel kernel_##suffix{force_##suffix, energy_##suffix};
PLICA_INTERNAL_FORCE(any, TwoDoubles, )
PLICA_INTERNAL_FORCE(fused, FourDoubles, PLICA_FUSED)
PLICA_INTERNAL_FORCE(largest, EightDoubles, PLICA_LARGEST)
#undef PLICA_INTERNAL_FORCE

}  // namespace

const InternalForceKernel& internal_force_kernel() {
  static const InternalForceKernel& chosen = takes_largest() ? kernel_largest
                                             : takes_fused() ? kernel_fused
                                                             : kernel_any;
  return chosen;
}

}  // namespace plica
