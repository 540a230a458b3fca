#pragma once
// Kernels in versions: one body (PLICA_INLINE) compiled into functions for any x86-64 processor and for those that
// can do more, of which the processor at hand decides. For source files; elsewhere there is the first version
// alone.

#if defined(__x86_64__) && defined(__GNUC__)
#define PLICA_INLINE inline __attribute__((always_inline))
/// AVX2 without fused multiply-add: the same bits.
#define PLICA_WIDE __attribute__((target("avx2")))
/// AVX2 with it: the last digits may be others.
#define PLICA_FUSED __attribute__((target("avx2,fma")))
/// AVX-512 with it: the bits of PLICA_FUSED.
#define PLICA_LARGEST __attribute__((target("avx512f,avx512vl,avx512dq,avx2,fma")))
#else
#define PLICA_INLINE inline
#define PLICA_WIDE
#define PLICA_FUSED
#define PLICA_LARGEST
#endif

namespace plica {

/// Whether this processor takes what is compiled as PLICA_WIDE, PLICA_FUSED, PLICA_LARGEST; each only with those
/// before.
bool takes_wide();
bool takes_fused();
bool takes_largest();

}  // namespace plica

/// Defines `name` from name_body, any or wide, chosen when called; parameters and arguments in parentheses.
#define PLICA_VERSIONS(name, parameters, arguments)                        \
  PLICA_WIDE static void name##_wide parameters { name##_body arguments; } \
  static void name parameters {                                            \
    static const bool wide = plica::takes_wide();                          \
    if (wide)                                                              \
      name##_wide arguments;                                               \
    else                                                                   \
      name##_body arguments;                                               \
  }

/// The passes of the loop that follows are independent of each other.
#if defined(__clang__)
#define PLICA_INDEPENDENT _Pragma("clang loop vectorize(assume_safety)")
#elif defined(__GNUC__)
#define PLICA_INDEPENDENT _Pragma("GCC ivdep")
#else
#define PLICA_INDEPENDENT
#endif
