#include "../borders.hpp"
#include "plica/contact/airway.hpp"
#include "plica/contact/complementarity.hpp"
#include "plica/contact/friction.hpp"
#include "plica/contact/pairs.hpp"
#include "plica/contact/surface.hpp"

using namespace plica;
using borders::indices;
using borders::Longer;
using borders::numbers;
using borders::sizes;

TEST_CASE("an airway refuses nodes that are not there") {
  Points x(6, 3);
  x << 0, 0, 0, 0, 1, 0, 0, 0, 1, 1, 0, 0, 1, 1, 0, 1, 0, 1;
  Triangles first(1, 3), second(1, 3);
  first << 0, 1, 2;
  second << 3, 5, 4;
  const auto match = [&] { matched_airway(x, first, second, Vector3::UnitX()); };
  sizes("matched_airway points", x, match, Longer::unread);
  indices("matched_airway first", first, match);
  indices("matched_airway second", second, match);
  Tets tets = matched_airway(x, first, second, Vector3::UnitX()).tets;
  const auto turned = [&] { find_inverted(x, tets); };
  sizes("find_inverted x", x, turned, Longer::unread);
  indices("find_inverted tets", tets, turned);
  std::vector<std::int32_t> among{0, 2};
  const auto turned_among = [&] { find_inverted(x, tets, among); };
  indices("find_inverted tets", tets, turned_among);
  indices("find_inverted among", among, turned_among);
  Neighbourhood part{{0}, {0}, {0, 2}};
  Detector detector(matched_airway(x, first, second, Vector3::UnitX()), x);
  const auto look = [&] { detector.look_at(part); };
  indices("Neighbourhood first", part.first, look);
  indices("Neighbourhood second", part.second, look);
  indices("Neighbourhood tets", part.tets, look);
}

TEST_CASE("surfaces and dense complementarity problems refuse what is of another size") {
  Triangles triangles(1, 3);
  triangles << 0, 1, 2;
  indices("ContactSurface::ContactSurface triangles", triangles, [&] { ContactSurface(triangles, 3); });
  Eigen::MatrixXd W = Eigen::MatrixXd::Identity(3, 3);
  Vector q = Vector::Constant(3, -1.0), start = Vector::Zero(3);
  std::vector<char> guess(3);
  const auto normal = [&] { solve_complementarity(W, q, guess, 1e-9, 20); };
  sizes("solve_complementarity W", W, normal);
  sizes("solve_complementarity q", q, normal);
  sizes("solve_complementarity guess", guess, normal);
  int most = 20;
  numbers("solve_complementarity most_pivots", most, {0, -1},
          [&] { solve_complementarity(W, q, guess, 1e-9, most); });
  Vector force = Vector::Ones(3), gap = Vector::Zero(3);
  const auto search = [&] {
    pivot(
        guess, [&](const std::vector<char>&, Vector& p, Vector& w) { p = force, w = gap; }, 1e-9, most);
  };
  sizes("pivot active", guess, search);
  sizes("pivot solve", force, search);
  sizes("pivot solve", gap, search);
  numbers("pivot most_pivots", most, {0, -1}, search);
  const auto rough = [&] { solve_coulomb(W, q, 0.5, start, 1e-9, 20); };
  sizes("solve_coulomb W", W, rough);
  sizes("solve_coulomb q", q, rough);
  sizes("solve_coulomb start", start, rough);
}
