#pragma once
// A row kernel is compiled twice, for any x86-64 processor and for those with AVX2, and chosen when called.
// The wide version has no fused multiply-add: both give the same bits.

#if defined(__x86_64__) && defined(__GNUC__)
#define PLICA_INLINE inline __attribute__((always_inline))
/// Defines `name` from name_body; parameters and arguments in parentheses.
#define PLICA_VERSIONS(name, parameters, arguments)                                             \
  __attribute__((target("avx2"))) static void name##_wide parameters { name##_body arguments; } \
  static void name parameters {                                                                 \
    static const bool has_wide = (__builtin_cpu_init(), __builtin_cpu_supports("avx2"));        \
    if (has_wide)                                                                               \
      name##_wide arguments;                                                                    \
    else                                                                                        \
      name##_body arguments;                                                                    \
  }
#else
#define PLICA_INLINE inline
#define PLICA_VERSIONS(name, parameters, arguments) \
  static void name parameters { name##_body arguments; }
#endif

/// The passes of the loop that follows are independent of each other.
#if defined(__clang__)
#define PLICA_INDEPENDENT _Pragma("clang loop vectorize(assume_safety)")
#elif defined(__GNUC__)
#define PLICA_INDEPENDENT _Pragma("GCC ivdep")
#else
#define PLICA_INDEPENDENT
#endif
