#include "plica/core/versions.hpp"

#if defined(__x86_64__) && defined(__GNUC__)
#include <cpuid.h>
#endif

namespace plica {
namespace {

struct Takes {
  bool wide = false, fused = false, largest = false;
};

/// Asked of the processor itself: __builtin_cpu_supports asks the compiler's run time, and Zig's says no to all.
/// Intel's manual, vol. 1, 14.3 and 15.2: the instructions are there (cpuid) and the system keeps the registers
/// that they use (xgetbv).
Takes ask() {
  Takes takes;
#if defined(__x86_64__) && defined(__GNUC__)
  unsigned a = 0, b = 0, c = 0, d = 0;
  if (__get_cpuid(1, &a, &b, &c, &d) == 0 || (c & bit_OSXSAVE) == 0) return takes;
  const bool avx = (c & bit_AVX) != 0, fma = (c & bit_FMA) != 0;
  unsigned kept = 0, high = 0;
  __asm__("xgetbv" : "=a"(kept), "=d"(high) : "c"(0));
  const bool keeps_avx = (kept & 0x06) == 0x06, keeps_avx512 = (kept & 0xe6) == 0xe6;
  if (__get_cpuid_count(7, 0, &a, &b, &c, &d) == 0) return takes;
  takes.wide = avx && keeps_avx && (b & bit_AVX2) != 0;
  takes.fused = takes.wide && fma;
  constexpr unsigned avx512 = bit_AVX512F | bit_AVX512VL | bit_AVX512DQ;
  takes.largest = takes.fused && keeps_avx512 && (b & avx512) == avx512;
#endif
  return takes;
}

const Takes& taken() {
  static const Takes takes = ask();
  return takes;
}

}  // namespace

bool takes_wide() { return taken().wide; }

bool takes_fused() { return taken().fused; }

bool takes_largest() { return taken().largest; }

}  // namespace plica
