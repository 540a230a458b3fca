#include "../borders.hpp"
#include "plica/contact/airway.hpp"

using namespace plica;
using borders::indices;
using borders::Longer;
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
}
