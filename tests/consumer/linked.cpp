// The least that links the library: a container of its own comes back across the border, and what it throws is
// caught.
#include <iostream>
#include <plica/core/threads.hpp>
#include <plica/core/types.hpp>

int main() {
  try {
    plica::set_threads(0);
  } catch (const plica::InvalidInput& refused) {
    const bool good = plica::place_text({1.0, -0.5, 0.0}) == "(1, -0.5, 0) m";
    std::cout << refused.what() << '\n';
    return good ? 0 : 1;
  }
  return 1;
}
