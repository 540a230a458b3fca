#include "plica/tissue/internal_force.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "plica/core/require.hpp"
#include "plica/core/threads.hpp"
#include "plica/mesh/edges.hpp"
#include "plica/tissue/element.hpp"
#include "plica/tissue/internal_force_kernel.hpp"
#include "plica/tissue/stretch_law.hpp"

namespace plica {
namespace {

constexpr std::ptrdiff_t batches_a_chunk = 8;
constexpr std::ptrdiff_t nodes_a_chunk = 512;
constexpr int force_size = 30 * InternalForce::lanes;  // numbers of a batch

/// dxi/dX at a point of a cell: l_{k+1} is what its values at the nodes say it is.
Matrix3 inverse_jacobian(const Element& element, const std::array<double, 4>& at) {
  const Eigen::Matrix<double, Eigen::Dynamic, 3> gradients = element.gradients(at);
  Matrix3 inverse;
  for (int k = 0; k < 3; ++k) {
    inverse.row(k) = gradients.row(k + 1);
    for (int e = 4; e < gradients.rows(); ++e)
      for (const int end : tet_edges[static_cast<std::size_t>(e - 4)])
        if (end == k + 1) inverse.row(k) += 0.5 * gradients.row(e);
  }
  return inverse;
}

}  // namespace

InternalForce::InternalForce(const TetMesh& mesh, const Tissue& tissue)
    : nodes_(mesh.node_count()), corners_(mesh.order() == 2 ? 4 : 1) {
  tissue.validate(mesh);
  const Points& rest = mesh.stretched() ? mesh.rest : mesh.points;
  if (mesh.stretched()) offset_ = as_vector(Points(mesh.points - mesh.rest));
  std::vector<StretchLaw> laws;
  for (const Material& material : tissue.materials) laws.emplace_back(material);
  const int nodes = mesh.order() == 2 ? 10 : 4;

  // Cells with straight sides first, so that few batches need a map a point.
  std::vector<std::int32_t> order(static_cast<std::size_t>(mesh.cell_count()));
  std::iota(order.begin(), order.end(), 0);
  std::vector<char> curved(order.size(), 0);
  Element element(mesh.order());
  for (const std::int32_t c : order) {
    element.place(rest, mesh.cells.row(c).data());
    curved[static_cast<std::size_t>(c)] = element.curved() ? 1 : 0;
  }
  std::stable_partition(order.begin(), order.end(),
                        [&](std::int32_t c) { return curved[static_cast<std::size_t>(c)] == 0; });

  const auto count = static_cast<std::ptrdiff_t>(order.size());
  const auto& rule = tetrahedron_rule_degree_5();
  for (std::ptrdiff_t first = 0; first < count; first += lanes) {
    Batch batch{};
    batch.map = static_cast<std::ptrdiff_t>(maps_.size());
    for (int lane = 0; lane < lanes; ++lane)
      batch.curved |=
          curved[static_cast<std::size_t>(
              order[static_cast<std::size_t>(std::min<std::ptrdiff_t>(first + lane, count - 1))])] != 0;
    const std::size_t points = batch.curved ? rule.size() : 1;
    maps_.resize(maps_.size() + points);
    for (int lane = 0; lane < lanes; ++lane) {
      const bool filler = first + lane >= count;
      const std::int32_t c = order[static_cast<std::size_t>(std::min<std::ptrdiff_t>(first + lane, count - 1))];
      const std::int32_t* cell = mesh.cells.row(c).data();
      element.place(rest, cell);
      batch.cell[lane] = c;
      for (int a = 0; a < nodes; ++a) batch.node[a][lane] = cell[a];
      const auto m = static_cast<std::size_t>(tissue.cell_material[c]);
      const StretchLaw::Moduli moduli = laws[m].moduli();
      const double eta = tissue.materials[m].viscosity;
      const double numbers[] = {moduli.mu,
                                moduli.lambda,
                                moduli.beta,
                                2 * moduli.shear,
                                moduli.along - 4 * moduli.shear,
                                moduli.fibre_modulus,
                                4 * moduli.stiffening,
                                moduli.active,
                                moduli.matrix_stiffening,
                                eta,
                                moduli.fibre[0],
                                moduli.fibre[1],
                                moduli.fibre[2]};
      for (int k = 0; k < 13; ++k) batch.law[k][lane] = numbers[k];
      batch.stiffens |= moduli.stiffening > 0;
      batch.matrix_stiffens |= moduli.matrix_stiffening > 0;
      batch.pulls |= moduli.active != 0;
      viscous_ |= eta > 0;
      for (std::size_t p = 0; p < points; ++p) {
        Map& map = maps_[static_cast<std::size_t>(batch.map) + p];
        const Matrix3 inverse = inverse_jacobian(element, rule[p].at);
        for (int k = 0; k < 9; ++k) map.inverse[k][lane] = inverse(k / 3, k % 3);
        map.volume[lane] = filler ? 0.0 : element.measure(rule[p].at);
      }
    }
    batches_.push_back(batch);
  }

  first_.assign(static_cast<std::size_t>(nodes_) + 1, 0);
  const auto for_each_place = [&](const auto& visit) {
    for (std::size_t b = 0; b < batches_.size(); ++b)
      for (int lane = 0; lane < lanes && static_cast<std::ptrdiff_t>(b) * lanes + lane < count; ++lane)
        for (int a = 0; a < nodes; ++a)
          visit(static_cast<std::size_t>(batches_[b].node[a][lane]),
                static_cast<std::int32_t>(b) * force_size + 3 * a * lanes + lane);
  };
  for_each_place([&](std::size_t node, std::int32_t) { ++first_[node + 1]; });
  std::partial_sum(first_.begin(), first_.end(), first_.begin());
  place_.resize(static_cast<std::size_t>(first_.back()));
  std::vector<std::int32_t> next(first_.begin(), first_.end() - 1);
  for_each_place(
      [&](std::size_t node, std::int32_t place) { place_[static_cast<std::size_t>(next[node]++)] = place; });
}

std::optional<std::int32_t> InternalForce::at(const Vector& u, const Vector& v, Force& force) const {
  require_size("InternalForce", "u", u.size(), 3 * nodes_);
  if (viscous_) require_size("InternalForce", "v", v.size(), 3 * nodes_);
  const auto count = static_cast<std::ptrdiff_t>(batches_.size());
  const InternalForceKernel& kernel = internal_force_kernel();
  const InternalForceInput input{u.data(), offset_.size() > 0 ? offset_.data() : nullptr,
                                 viscous_ ? v.data() : nullptr, corners_};
  Vector elastic(count * force_size), viscous(viscous_ ? count * force_size : 0), least(count * lanes);
  for_chunks(count, batches_a_chunk, [&](std::ptrdiff_t begin, std::ptrdiff_t end, std::ptrdiff_t) {
    for (std::ptrdiff_t b = begin; b < end; ++b) {
      const Batch& batch = batches_[static_cast<std::size_t>(b)];
      kernel.force(batch, maps_.data() + batch.map, input, elastic.data() + b * force_size,
                   viscous_ ? viscous.data() + b * force_size : nullptr, least.data() + b * lanes);
    }
  });
  std::optional<std::int32_t> failed;
  for (std::ptrdiff_t k = 0; k < least.size(); ++k)
    if (const std::int32_t cell = batches_[static_cast<std::size_t>(k / lanes)].cell[k % lanes];
        !(least[k] > 0) && (!failed || cell < *failed))
      failed = cell;
  if (failed) return failed;
  force.elastic.resize(3 * nodes_);
  force.viscous.resize(viscous_ ? 3 * nodes_ : 0);
  const auto gather = [&](const Vector& all, std::ptrdiff_t begin, std::ptrdiff_t end, Vector& out) {
    for (std::ptrdiff_t i = begin; i < end; ++i) {
      Vector3 sum = Vector3::Zero();
      for (std::int32_t k = first_[static_cast<std::size_t>(i)]; k < first_[static_cast<std::size_t>(i) + 1];
           ++k) {
        const double* at = all.data() + place_[static_cast<std::size_t>(k)];
        for (int c = 0; c < 3; ++c) sum[c] += at[c * lanes];
      }
      out.segment<3>(3 * i) = sum;
    }
  };
  for_chunks(nodes_, nodes_a_chunk, [&](std::ptrdiff_t begin, std::ptrdiff_t end, std::ptrdiff_t) {
    gather(elastic, begin, end, force.elastic);
    if (viscous_) gather(viscous, begin, end, force.viscous);
  });
  return std::nullopt;
}

double InternalForce::energy(const Vector& u) const {
  require_size("InternalForce", "u", u.size(), 3 * nodes_);
  const auto count = static_cast<std::ptrdiff_t>(batches_.size());
  const InternalForceKernel& kernel = internal_force_kernel();
  const InternalForceInput input{u.data(), offset_.size() > 0 ? offset_.data() : nullptr, nullptr, corners_};
  Vector energies(count * lanes);
  for_chunks(count, batches_a_chunk, [&](std::ptrdiff_t begin, std::ptrdiff_t end, std::ptrdiff_t) {
    for (std::ptrdiff_t b = begin; b < end; ++b) {
      const Batch& batch = batches_[static_cast<std::size_t>(b)];
      kernel.energy(batch, maps_.data() + batch.map, input, energies.data() + b * lanes);
    }
  });
  return energies.sum();
}

}  // namespace plica
