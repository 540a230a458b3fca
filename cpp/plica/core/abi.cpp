#include "plica/core/abi.hpp"

namespace plica::the_library_must_be {

const char PLICA_STANDARD_LIBRARY = 1, PLICA_CONTAINERS = 1, PLICA_EIGEN = 1;

}  // namespace plica::the_library_must_be
