#pragma once
// What a public function asks of its arrays, said once and in one form; kernels below it trust.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>

namespace plica {

/// Throws InvalidInput "Where: size of name = size; must be relation."
[[noreturn]] void refuse_size(const char* where, const std::string& name, std::ptrdiff_t size,
                              const std::string& relation);
/// Throws InvalidInput "Where: name = index; must be in [0, count)."
[[noreturn]] void refuse_index(const char* where, const std::string& name, std::ptrdiff_t index,
                               std::ptrdiff_t count);

/// Throws InvalidInput unless `size` is what it must be: one comparison.
inline void require_size(const char* where, const char* name, std::ptrdiff_t size, std::ptrdiff_t wanted) {
  if (size != wanted) refuse_size(where, name, size, std::to_string(wanted));
}

/// Throws InvalidInput unless `size` is one of two.
inline void require_size(const char* where, const char* name, std::ptrdiff_t size, std::ptrdiff_t one,
                         std::ptrdiff_t other) {
  if (size != one && size != other)
    refuse_size(where, name, size, std::to_string(one) + " or " + std::to_string(other));
}

/// Throws InvalidInput unless `size` is a whole number of rows of `width`.
inline void require_rows(const char* where, const char* name, std::ptrdiff_t size, std::ptrdiff_t width) {
  if (size % width != 0) refuse_size(where, name, size, "a multiple of " + std::to_string(width));
}

/// Throws InvalidInput where `size` is less than what is read.
inline void require_at_least(const char* where, const char* name, std::ptrdiff_t size, std::ptrdiff_t least) {
  if (size < least) refuse_size(where, name, size, ">= " + std::to_string(least));
}

/// Throws InvalidInput unless 0 <= index < count.
inline void require_index(const char* where, const char* name, std::ptrdiff_t index, std::ptrdiff_t count) {
  if (index < 0 || index >= count) refuse_index(where, name, index, count);
}

/// Throws InvalidInput unless 0 <= begin <= end <= count.
inline void require_range(const char* where, std::ptrdiff_t begin, std::ptrdiff_t end, std::ptrdiff_t count) {
  require_index(where, "the first row", begin, count + 1);
  if (end < begin || end > count)
    refuse_size(where, "the rows", end - begin, "in [0, " + std::to_string(count - begin) + "]");
}

/// Throws InvalidInput naming the first of these indices that is not in [0, count). O(their number).
template <typename Array>
void require_indices(const char* where, const char* name, const Array& indices, std::ptrdiff_t count) {
  const std::int32_t* const data = indices.data();
  const auto n = static_cast<std::ptrdiff_t>(indices.size());
  std::uint32_t largest = 0;  // a negative one wraps to more than any count
  for (std::ptrdiff_t i = 0; i < n; ++i) largest = std::max(largest, static_cast<std::uint32_t>(data[i]));
  if (n == 0 || static_cast<std::ptrdiff_t>(largest) < count) return;
  for (std::ptrdiff_t i = 0; i < n; ++i) require_index(where, name, data[i], count);
}

}  // namespace plica
