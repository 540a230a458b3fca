#include <doctest/doctest.h>

#include <algorithm>
#include <atomic>
#include <thread>
#include <vector>

#include "plica/core/error.hpp"
#include "plica/core/threads.hpp"

using namespace plica;

namespace {

/// How often each of n items was visited; the chunk limits are checked on the way.
std::vector<int> visits(std::ptrdiff_t n, std::ptrdiff_t size) {
  std::vector<int> count(static_cast<std::size_t>(n), 0);
  std::atomic<bool> good{true};
  for_chunks(n, size, [&](std::ptrdiff_t begin, std::ptrdiff_t end, std::ptrdiff_t chunk) {
    if (begin != chunk * size || end != std::min(n, begin + size)) good = false;
    for (std::ptrdiff_t i = begin; i < end; ++i) ++count[static_cast<std::size_t>(i)];
  });
  CHECK(good);
  return count;
}

}  // namespace

TEST_CASE("every item is visited once for any number of threads") {
  for (int count : {1, 2, 5, 2, 1}) {
    set_threads(count);
    CHECK(threads() == count);
    for (std::ptrdiff_t n : {0, 1, 7, 1000, 1001}) {
      for (std::ptrdiff_t size : {1, 10, 5000}) {
        CHECK(visits(n, size) == std::vector<int>(static_cast<std::size_t>(n), 1));
      }
    }
  }
  set_threads(1);
}

TEST_CASE("thousands of short loops leave nothing undone") {
  set_threads(3);
  for (int repeat = 0; repeat < 3000; ++repeat) {
    std::atomic<int> sum{0};
    for_chunks(16, 2, [&](std::ptrdiff_t begin, std::ptrdiff_t end, std::ptrdiff_t) {
      sum += static_cast<int>(end - begin);
    });
    REQUIRE(sum == 16);
  }
  set_threads(1);
}

TEST_CASE("two threads may call at once, and a call may be nested") {
  set_threads(2);
  std::atomic<int> total{0};
  const auto caller = [&] {
    for (int repeat = 0; repeat < 200; ++repeat) {
      for_chunks(8, 1, [&](std::ptrdiff_t, std::ptrdiff_t, std::ptrdiff_t) {
        for_chunks(4, 1, [&](std::ptrdiff_t, std::ptrdiff_t, std::ptrdiff_t) { ++total; });
      });
    }
  };
  std::thread other(caller);
  caller();
  other.join();
  set_threads(1);
  CHECK(total == 2 * 200 * 8 * 4);
}

TEST_CASE("a thread count below one is refused") {
  CHECK_THROWS_WITH_AS(set_threads(0), "set_threads: count = 0; must be in [1, 1024].", InvalidInput);
  CHECK_THROWS_AS(for_chunks(3, 0, [](std::ptrdiff_t, std::ptrdiff_t, std::ptrdiff_t) {}), InvalidInput);
  CHECK(threads() == 1);
}
