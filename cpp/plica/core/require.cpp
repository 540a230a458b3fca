#include "plica/core/require.hpp"

#include "plica/core/error.hpp"

namespace plica {

void refuse_size(const char* where, const std::string& name, std::ptrdiff_t size, const std::string& relation) {
  throw InvalidInput(where, "size of " + name, static_cast<double>(size), "", relation);
}

void refuse_index(const char* where, const std::string& name, std::ptrdiff_t index, std::ptrdiff_t count) {
  throw InvalidInput(where, name, static_cast<double>(index), "", "in [0, " + std::to_string(count) + ")");
}

}  // namespace plica
