#include "../borders.hpp"
#include "plica/meshing/triangulated_airway.hpp"

using namespace plica;
using borders::indices;
using borders::Longer;
using borders::sizes;

TEST_CASE("a triangulated airway refuses nodes that are not there") {
  Points x(6, 3);
  x << 0, 0, 0, 0, 1, 0, 0, 0, 1, 1, 0, 0, 1, 1, 0, 1, 0, 1;
  Triangles first(1, 3), second(1, 3);
  first << 0, 1, 2;
  second << 3, 5, 4;
  const auto join = [&] { triangulated_airway(x, first, second); };
  sizes("triangulated_airway points", x, join, Longer::unread);
  indices("triangulated_airway first", first, join);
  indices("triangulated_airway second", second, join);
}
