#include "arrays.hpp"
#include "engine.hpp"
#include "plica/airflow/load_patterns.hpp"
#include "plica/core/threads.hpp"
#include "plica/dynamics/scheme.hpp"
#include "plica/estimation/sweep.hpp"
#include "plica/estimation/toeplitz.hpp"
#include "plica/tissue/assembly.hpp"
#include "plica/tissue/sensitivity.hpp"

using namespace plica;
using namespace plica::estimation;
using namespace plica::python;

namespace {

using Released = py::gil_scoped_release;
using Held = py::array_t<bool, py::array::c_style | py::array::forcecast>;
using Coefficients = Eigen::Matrix<double, Eigen::Dynamic, 6, Eigen::RowMajor>;

/// The matrices of a mesh and its grouping of cells, affine in the tissue's coefficients.
struct AffineTissue {
  std::shared_ptr<TetMesh> mesh;
  Tissue tissue;
  Supports supports;
  Assembler assembler;
  NodalMatrix mass;
  AffineStiffness affine;
  FactorPlan plan;  // of the step's matrix, whatever the coefficients

  std::ptrdiff_t groups() const { return static_cast<std::ptrdiff_t>(tissue.materials.size()); }
};

std::unique_ptr<AffineTissue> make_affine(const std::shared_ptr<TetMesh>& mesh, std::vector<Material> materials,
                                          std::vector<std::string> names, const py::array& cell_material,
                                          const Held& fixed) {
  if (fixed.ndim() != 2 || fixed.shape(0) != mesh->node_count() || fixed.shape(1) != 3)
    wrong_shape("AffineTissue", "fixed", fixed, "(" + std::to_string(mesh->node_count()) + ", 3)");
  Supports supports(mesh->node_count());
  for (std::int32_t i = 0; i < mesh->node_count(); ++i)
    for (int c = 0; c < 3; ++c)
      if (fixed.at(i, c)) supports.fix(i, c);
  Tissue tissue{std::move(materials), std::move(names),
                to_indices(cell_material, "AffineTissue", "cell_material")};
  const Released released;
  tissue.validate(*mesh);
  Assembler assembler(*mesh);
  NodalMatrix mass = assembler.mass(tissue);
  AffineStiffness affine(assembler, tissue);
  FactorPlan plan = sweep_plan(mass.pattern(), supports);
  return std::unique_ptr<AffineTissue>(new AffineTissue{mesh, std::move(tissue), std::move(supports),
                                                        std::move(assembler), std::move(mass), std::move(affine),
                                                        std::move(plan)});
}

void require_shape(const RealArray& array, const std::vector<py::ssize_t>& shape, const std::string& name) {
  std::string wanted;
  bool same = array.ndim() == static_cast<py::ssize_t>(shape.size());
  for (std::size_t k = 0; k < shape.size(); ++k) {
    wanted += (k ? ", " : "(") + std::to_string(shape[k]);
    same = same && array.shape(static_cast<py::ssize_t>(k)) == shape[k];
  }
  if (!same) wrong_shape("AffineTissue", name, array, wanted + ")");
}

Coefficients coefficients_at(const double* data, std::ptrdiff_t groups) {
  return Eigen::Map<const Coefficients>(data, groups, 6);
}

std::optional<BlockMatrix> viscosity_of(const AffineTissue& self, const Vector& eta) {
  if ((eta.array() == 0).all()) return std::nullopt;
  return self.affine.viscosity(eta);
}

py::array_t<double> responses(const AffineTissue& self, const RealArray& coefficients, const RealArray& viscosity,
                              const RealArray& coefficient_derivatives, const RealArray& viscosity_derivatives,
                              const RealArray& patterns, const py::array& observed, std::ptrdiff_t steps,
                              double alpha, double step, double tolerance) {
  const std::ptrdiff_t g = self.groups();
  require_shape(coefficients, {g, 6}, "coefficients");
  require_shape(viscosity, {g}, "viscosity");
  const std::ptrdiff_t p = coefficient_derivatives.ndim() > 0 ? coefficient_derivatives.shape(0) : 0;
  require_shape(coefficient_derivatives, {p, g, 6}, "coefficient_derivatives");
  require_shape(viscosity_derivatives, {p, g}, "viscosity_derivatives");
  if (patterns.ndim() != 2) wrong_shape("AffineTissue", "patterns", patterns, "(3 n, q)");
  const SchemeCoefficients scheme = plica::scheme_coefficients(HilberHughesTaylor{alpha});
  const Indices unknowns = to_indices(observed, "AffineTissue", "observed");
  const RowMatrix forces = Eigen::Map<const RowMatrix>(patterns.data(), patterns.shape(0), patterns.shape(1));
  RowMatrix out;
  {
    const Released released;
    const BlockMatrix K = self.affine.stiffness(coefficients_at(coefficients.data(), g));
    const std::optional<BlockMatrix> C = viscosity_of(self, Eigen::Map<const Vector>(viscosity.data(), g));
    std::vector<Direction> directions(static_cast<std::size_t>(p));
    for (std::ptrdiff_t j = 0; j < p; ++j) {
      Direction& direction = directions[static_cast<std::size_t>(j)];
      const Coefficients d = coefficients_at(coefficient_derivatives.data() + j * g * 6, g);
      if (!d.isZero(0)) direction.stiffness = without_zero_blocks(self.affine.stiffness(d));
      if (auto d_C = viscosity_of(self, Eigen::Map<const Vector>(viscosity_derivatives.data() + j * g, g)))
        direction.viscosity = without_zero_blocks(*d_C);
    }
    const LinearMotion motion{self.mass, C, K, self.supports, scheme.alpha, scheme.beta, scheme.gamma, step};
    out = impulse_responses(motion, forces, directions, unknowns, steps, tolerance, &self.plan);
  }
  return give(std::move(out))
      .reshape(std::vector<py::ssize_t>{steps, unknowns.size(), (1 + p) * patterns.shape(1)});
}

BlockToeplitz to_toeplitz(const RealArray& lags, const std::string& name) {
  if (lags.ndim() != 3 || lags.shape(0) < 1) wrong_shape("toeplitz", name, lags, "(blocks, rows, columns)");
  return {Eigen::Map<const BlockToeplitz::Lags>(lags.data(), lags.shape(0) * lags.shape(1), lags.shape(2)),
          lags.shape(0)};
}

BlockToeplitz::Lags to_matrix(const RealArray& array, std::ptrdiff_t rows, const std::string& name) {
  if (array.ndim() != 2 || array.shape(0) != rows)
    wrong_shape("toeplitz", name, array, "(" + std::to_string(rows) + ", c)");
  return Eigen::Map<const BlockToeplitz::Lags>(array.data(), array.shape(0), array.shape(1));
}

void bind_toeplitz(py::module_& engine) {
  engine.def(
      "toeplitz_gram",
      [](const RealArray& first, const RealArray& second, const RealArray& weights) {
        const BlockToeplitz A = to_toeplitz(first, "first"), B = to_toeplitz(second, "second");
        if (A.blocks != B.blocks || A.rows() != B.rows())
          wrong_shape("toeplitz", "second", second, "as many blocks and rows as first");
        const auto W = to_matrix(weights, A.blocks, "weights");
        if (W.cols() != A.rows()) wrong_shape("toeplitz", "weights", weights, "(blocks, rows)");
        BlockToeplitz::Lags gram;
        {
          const Released released;
          gram = toeplitz_gram(A, B, W);
        }
        return give(std::move(gram));
      },
      py::arg("first"), py::arg("second"), py::arg("weights"));
  engine.def(
      "toeplitz_product",
      [](const RealArray& lags, const RealArray& x) {
        const BlockToeplitz T = to_toeplitz(lags, "lags");
        const auto right = to_matrix(x, T.blocks * T.columns(), "x");
        const auto product = [&] {
          const Released released;
          return toeplitz_product(T, right);
        };
        return give(product());
      },
      py::arg("lags"), py::arg("x"));
  engine.def(
      "toeplitz_transposed_product",
      [](const RealArray& lags, const RealArray& x) {
        const BlockToeplitz T = to_toeplitz(lags, "lags");
        const auto right = to_matrix(x, T.blocks * T.rows(), "x");
        const auto product = [&] {
          const Released released;
          return toeplitz_transposed_product(T, right);
        };
        return give(product());
      },
      py::arg("lags"), py::arg("x"));
}

py::array_t<double> patterns_of(const TetMesh& mesh, const py::array& faces, const RealArray& heights) {
  if (heights.ndim() != 1 || heights.size() < 2)
    wrong_shape("pressure_patterns", "heights", heights, "(s,), s >= 2");
  const Vector height = Eigen::Map<const Vector>(heights.data(), heights.size());
  for (std::ptrdiff_t i = 1; i < height.size(); ++i)
    if (!(height[i] > height[i - 1]))
      throw InvalidInput("pressure_patterns", "heights[" + std::to_string(i) + "]", height[i], "m",
                         "> " + number_text(height[i - 1]) + ", the one before");
  const Faces rows = to_rows(faces, {mesh.order() == 2 ? 6 : 3}, "pressure_patterns", "faces");
  check_nodes(rows, mesh.node_count(), "pressure_patterns", "face");
  RowMatrix dense;
  {
    const Released released;
    dense = load_patterns(mesh.points, rows, height, 1e-9 * (height[height.size() - 1] - height[0])).sections;
  }
  return give(std::move(dense));
}

}  // namespace

void bind_estimation_sweep(py::module_& engine) {
  engine.def(
      "stiffness_coefficients", [](const Material& m) { return give(Vector(stiffness_coefficients(m))); },
      py::arg("material"));
  engine.def("stiffness_parameters", &stiffness_parameters, py::arg("material"));
  engine.def(
      "stiffness_derivative",
      [](const Material& m, const std::string& parameter) {
        return give(Vector(stiffness_derivative(m, parameter)));
      },
      py::arg("material"), py::arg("parameter"));
  engine.def("pressure_patterns", &patterns_of, py::arg("mesh"), py::arg("faces"), py::arg("heights"));
  py::class_<AffineTissue>(engine, "AffineTissue")
      .def(py::init(&make_affine), py::arg("mesh"), py::arg("materials"), py::arg("material_names"),
           py::arg("cell_material"), py::arg("fixed"))
      .def_property_readonly("groups", &AffineTissue::groups)
      .def("mass", [](const AffineTissue& self) { return give_csr(self.mass.to_sparse()); })
      .def(
          "stiffness",
          [](const AffineTissue& self, const RealArray& coefficients) {
            require_shape(coefficients, {self.groups(), 6}, "coefficients");
            return give_csr(
                self.affine.stiffness(coefficients_at(coefficients.data(), self.groups())).to_sparse());
          },
          py::arg("coefficients"))
      .def(
          "viscosity",
          [](const AffineTissue& self, const RealArray& viscosity) {
            require_shape(viscosity, {self.groups()}, "viscosity");
            const Vector eta = Eigen::Map<const Vector>(viscosity.data(), self.groups());
            return give_csr(self.affine.viscosity(eta).to_sparse());
          },
          py::arg("viscosity"))
      .def("impulse_responses", &responses, py::kw_only(), py::arg("coefficients"), py::arg("viscosity"),
           py::arg("coefficient_derivatives"), py::arg("viscosity_derivatives"), py::arg("patterns"),
           py::arg("observed"), py::arg("steps"), py::arg("alpha"), py::arg("step"), py::arg("tolerance") = 1e-12);
  bind_toeplitz(engine);
}
