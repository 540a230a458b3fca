#include <doctest/doctest.h>

#include <Eigen/Dense>
#include <limits>

#include "../approx.hpp"
#include "plica/core/error.hpp"
#include "plica/tissue/material.hpp"
#include "scenes.hpp"

using namespace plica;

namespace {

// Paper A, Table III, in SI.
std::vector<std::pair<std::string, Material>> thesis_layers() {
  return {{"cover", scenes::transverse(1e3, 0.66, 10e3, 0.66, 10e3)},
          {"ligament", scenes::transverse(3e3, 0.58, 20e3, 0.58, 40e3)},
          {"body", scenes::transverse(20e3, 0.45, 40e3, 0.45, 30e3)}};
}

TransverselyIsotropic& law_of(Material& material) { return std::get<TransverselyIsotropic>(material.elasticity); }

// The compliance that engineers write down: strain along each axis under a stress along each axis.
Matrix6 compliance_along_y(double E, double nu, double E_fibre, double nu_fibre, double mu_fibre, double mu) {
  Matrix6 C = Matrix6::Zero();
  C(0, 0) = C(2, 2) = 1 / E;
  C(0, 2) = C(2, 0) = -nu / E;
  C(1, 1) = 1 / E_fibre;
  C(0, 1) = C(1, 0) = C(1, 2) = C(2, 1) = -nu_fibre / E_fibre;
  C(3, 3) = C(4, 4) = 1 / mu_fibre;
  C(5, 5) = 1 / mu;
  return C;
}

// Stress under a strain, through tensors: turn the strain into the frame R, apply S there, turn back.
Matrix6 turned_by_tensors(const Matrix6& S, const Matrix3& R) {
  constexpr int pair[6][2] = {{0, 0}, {1, 1}, {2, 2}, {0, 1}, {1, 2}, {2, 0}};
  Matrix6 result;
  for (int column = 0; column < 6; ++column) {
    const Matrix3 strain = R.transpose() * scenes::unit_strain(column) * R;
    Vector6 voigt;
    for (int i = 0; i < 6; ++i) voigt[i] = (i < 3 ? 1 : 2) * strain(pair[i][0], pair[i][1]);
    const Vector6 s = S * voigt;
    Matrix3 stress;
    stress << s[0], s[3], s[5], s[3], s[1], s[4], s[5], s[4], s[2];
    stress = R * stress * R.transpose();
    for (int i = 0; i < 6; ++i) result(i, column) = stress(pair[i][0], pair[i][1]);
  }
  return result;
}

double relative(const Matrix6& a, const Matrix6& b) { return (a - b).norm() / b.norm(); }

std::string message_of(const Material& material) {
  try {
    material.validate("tissue.cover");
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "";
}

}  // namespace

TEST_CASE("the elasticity matrix of each layer of the thesis is positive definite") {
  for (const auto& [name, material] : thesis_layers()) {
    CAPTURE(name);
    material.validate(name);
    const Vector6 values = Eigen::SelfAdjointEigenSolver<Matrix6>(elasticity_matrix(material)).eigenvalues();
    CHECK(values.minCoeff() > 1e-3 * values.maxCoeff());
  }
}

TEST_CASE("the elasticity matrix is the inverse of the textbook compliance") {
  for (auto [name, material] : thesis_layers()) {
    CAPTURE(name);
    for (const bool printed : {false, true}) {
      TransverselyIsotropic& law = law_of(material);
      if (printed) law.mu = law.E / (1 + law.nu);
      const double mu = law.mu.value_or(law.E / (2 * (1 + law.nu)));
      const Matrix6 C = compliance_along_y(law.E, law.nu, law.E_fibre, law.nu_fibre, law.mu_fibre, mu);
      // Round-off times the condition number, below 1e3.
      CHECK((elasticity_matrix(material) * C - Matrix6::Identity()).norm() < 1e-12);
    }
  }
}

TEST_CASE("with equal moduli the fibre law is the isotropic one") {
  Material isotropic;
  isotropic.elasticity = Isotropic{20e3, 0.45};
  Material fibred = scenes::transverse(20e3, 0.45, 20e3, 0.45, 20e3 / 2.9);
  law_of(fibred).fibre = Vector3(1, 2, -3);
  CHECK(relative(elasticity_matrix(fibred), elasticity_matrix(isotropic)) < 1e-14);
  CHECK(elasticity_matrix(isotropic)(3, 3) == approx(20e3 / 2.9).epsilon(1e-14));
  CHECK(relative(stiffness_coefficients(fibred).asDiagonal().toDenseMatrix(),
                 stiffness_coefficients(isotropic).asDiagonal().toDenseMatrix()) < 1e-14);
}

TEST_CASE("the plane across the fibre is isotropic with the default shear modulus, not with the printed one") {
  const Matrix3 turn = Eigen::AngleAxisd(30 * 3.141592653589793 / 180, Vector3::UnitY()).toRotationMatrix();
  for (auto [name, material] : thesis_layers()) {
    CAPTURE(name);
    const Matrix6 S = elasticity_matrix(material);
    CHECK(relative(turned_by_tensors(S, turn), S) < 1e-14);
    TransverselyIsotropic& law = law_of(material);
    law.mu = law.E / (1 + law.nu);
    const Matrix6 printed = elasticity_matrix(material);
    CHECK(relative(turned_by_tensors(printed, turn), printed) > 1e-2);
  }
}

TEST_CASE("a turned fibre turns the elasticity matrix as a tensor") {
  const Matrix6 S = elasticity_matrix(scenes::transverse(1e3, 0.66, 10e3, 0.66, 10e3));
  for (const Vector3& fibre : {Vector3(0, 0, 1), Vector3(1, 0, 0), Vector3(0.3, -0.8, 0.4), Vector3(0, -1, 0)}) {
    CAPTURE(fibre.transpose());
    Material material = scenes::transverse(1e3, 0.66, 10e3, 0.66, 10e3);
    law_of(material).fibre = 2.5 * fibre;
    // Any frame will do whose second axis is the fibre: S is isotropic across it.
    Matrix3 frame;
    frame.col(1) = fibre.normalized();
    frame.col(0) = fibre.normalized().unitOrthogonal();
    frame.col(2) = frame.col(0).cross(frame.col(1));
    CHECK(relative(elasticity_matrix(material), turned_by_tensors(S, frame)) < 1e-14);
    CHECK(elasticity_matrix(material) == elasticity_matrix(material).transpose());
  }
}

TEST_CASE("a fibre along z takes the stress of E_fibre along z") {
  Material material = scenes::transverse(1e3, 0.66, 10e3, 0.4, 7e3);
  law_of(material).fibre = Vector3::UnitZ();
  const Matrix6 C = elasticity_matrix(material).inverse();
  CHECK(1 / C(2, 2) == approx(10e3).epsilon(1e-12));
  CHECK(1 / C(0, 0) == approx(1e3).epsilon(1e-12));
  CHECK(1 / C(1, 1) == approx(1e3).epsilon(1e-12));
  CHECK(1 / C(5, 5) == approx(7e3).epsilon(1e-12));
  CHECK(1 / C(4, 4) == approx(7e3).epsilon(1e-12));
  CHECK(1 / C(3, 3) == approx(1e3 / 3.32).epsilon(1e-12));
}

TEST_CASE("stiff fibres and nearly incompressible tissue keep the elasticity matrix positive definite") {
  Material isotropic;
  isotropic.elasticity = Isotropic{20e3, 0.499};
  const Material stiff = scenes::transverse(1e3, 0.98, 60e3, 0.7, 1.1e3);  // E'/E = 60, E'/mu' = 54
  for (const Material& material : {isotropic, stiff}) {
    material.validate("tissue");
    CHECK(Eigen::SelfAdjointEigenSolver<Matrix6>(elasticity_matrix(material)).eigenvalues().minCoeff() > 0);
  }
}

TEST_CASE("viscosity acts on the strain tensor") {
  Material material;
  material.viscosity = 3;
  Vector6 diagonal;
  diagonal << 3, 3, 3, 1.5, 1.5, 1.5;
  CHECK(viscosity_matrix(material) == Matrix6(diagonal.asDiagonal()));
}

TEST_CASE("the bound k > 0 is exact: the elasticity matrix turns indefinite where it is violated") {
  Material material = scenes::transverse(20e3, 0.5, 40e3, 0.5, 10e3);  // largest nu: 0.75
  const auto least = [&](double nu) {
    law_of(material).nu = nu;
    return Eigen::SelfAdjointEigenSolver<Matrix6>(elasticity_matrix(material)).eigenvalues().minCoeff();
  };
  CHECK(least(0.7499) > 0);
  CHECK(message_of(material) == "");
  CHECK(least(0.7501) < 0);
  CHECK(message_of(material) ==
        "tissue.cover: nu = 0.7501; must be < 0.75 (k = E'(1 - nu) - 2 nu'^2 E > 0). "
        "Lower nu or nu_fibre, or raise E_fibre.");
}

TEST_CASE("where no nu fits the message bounds nu_fibre") {
  const Material material = scenes::transverse(10e3, 0.2, 10e3, 1.5, 10e3);
  CHECK(message_of(material) ==
        "tissue.cover: nu_fibre = 1.5; must be between -0.632456 and 0.632456 "
        "(k = E'(1 - nu) - 2 nu'^2 E > 0). No nu goes with it; lower nu_fibre, or raise E_fibre.");
}

TEST_CASE("every bound of a material is named with its value") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto refused = [&](auto change, const std::string& beginning) {
    Material material = scenes::transverse(1e3, 0.66, 10e3, 0.66, 10e3);
    change(material, law_of(material));
    CAPTURE(beginning);
    CHECK(message_of(material).find("tissue.cover: " + beginning) == 0);
  };
  using Law = TransverselyIsotropic;
  refused([](Material&, Law& l) { l.E = 0; }, "E = 0 Pa; must be > 0.");
  refused([](Material&, Law& l) { l.E_fibre = -1; }, "E_fibre = -1 Pa; must be > 0.");
  refused([](Material&, Law& l) { l.mu_fibre = 0; }, "mu_fibre = 0 Pa; must be > 0.");
  refused([](Material&, Law& l) { l.mu = -2; }, "mu = -2 Pa; must be > 0.");
  refused([](Material&, Law& l) { l.nu = -1; }, "nu = -1; must be > -1.");
  refused([](Material&, Law& l) { l.nu = 1; }, "nu = 1; must be < 1.");
  refused([&](Material&, Law& l) { l.nu_fibre = nan; }, "nu_fibre = nan; must be finite.");
  refused([&](Material&, Law& l) { l.fibre.x() = nan; }, "fibre = nan; must be finite.");
  refused([](Material&, Law& l) { l.fibre.setZero(); }, "length of fibre = 0; must be > 0.");
  refused([](Material& m, Law&) { m.density = 0; }, "density = 0 kg/m^3; must be > 0.");
  refused([](Material& m, Law&) { m.viscosity = -4; }, "viscosity = -4 Pa s; must be >= 0.");
  refused([](Material& m, Law&) { m.matrix_stiffening = -1; }, "matrix_stiffening = -1; must be >= 0.");
  refused([&](Material& m, Law&) { m.viscosity = nan; }, "viscosity = nan Pa s; must be finite.");
  refused([](Material& m, Law&) { m.elasticity = Isotropic{1e3, 0.5}; }, "nu = 0.5; must be < 0.5.");
  refused([](Material& m, Law&) { m.elasticity = Isotropic{1e3, -1}; }, "nu = -1; must be > -1.");
  refused([](Material& m, Law&) { m.elasticity = Isotropic{0, 0.3}; }, "E = 0 Pa; must be > 0.");
  refused(
      [](Material& m, Law&) {
        m = {Isotropic{1e3, 0.3}, 1040, 0, 1};
      },
      "stiffening = 1; must be 0 in isotropic tissue. Its fibres are what stiffens. Use matrix_stiffening.");
}
