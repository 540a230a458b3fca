#pragma once
#include <cstddef>
#include <functional>

#include "plica/core/error.hpp"

namespace plica {

/// Number of threads that later calls may use (1 until set); results do not depend on it.
void set_threads(int count);
int threads();

/// Calls work(begin, end, chunk) for the chunks [0, size), [size, 2 size), ... of [0, n), in parallel.
/// The chunks depend on n and size alone: a sum over chunk results taken in chunk order is the same
/// for any number of threads. Work must not throw. A nested call, or one made while another thread's is
/// under way, runs on its own thread alone.
void for_chunks(std::ptrdiff_t n, std::ptrdiff_t size,
                const std::function<void(std::ptrdiff_t begin, std::ptrdiff_t end, std::ptrdiff_t chunk)>& work);

/// Calls work(at, count) for slices of a vector of length n, in parallel: what is done entry by entry.
template <typename Work>
void for_slices(std::ptrdiff_t n, const Work& work) {
  for_chunks(n, 4096, [&](std::ptrdiff_t begin, std::ptrdiff_t end, std::ptrdiff_t) { work(begin, end - begin); });
}

}  // namespace plica
