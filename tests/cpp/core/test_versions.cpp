#include <doctest/doctest.h>

#include "plica/core/versions.hpp"

using namespace plica;

#if defined(__x86_64__) && defined(__GNUC__)
TEST_CASE("a processor takes the kernels that the compiler's run time says it takes") {
  __builtin_cpu_init();
  const bool wide = __builtin_cpu_supports("avx2"), fused = wide && __builtin_cpu_supports("fma");
  CHECK(takes_wide() == wide);
  CHECK(takes_fused() == fused);
  CHECK(takes_largest() == (fused && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl") &&
                            __builtin_cpu_supports("avx512dq")));
}
#else
TEST_CASE("a processor of another kind takes the kernels for any") { CHECK_FALSE(takes_wide()); }
#endif
