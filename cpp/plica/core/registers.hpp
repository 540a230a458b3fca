#pragma once
// Registers of processors as vectors of numbers, for kernels in versions (versions.hpp): a vector wider than the
// processor's goes through memory. For source files.

#if !defined(__GNUC__)
#error "plica: kernels need the vector types of GCC or Clang"
#endif

namespace plica {

// In structs: a template drops the attributes of its arguments.
struct TwoDoubles {
  typedef double Register __attribute__((vector_size(16), aligned(8), may_alias));
};
struct FourDoubles {
  typedef double Register __attribute__((vector_size(32), aligned(8), may_alias));
};
struct EightDoubles {
  typedef double Register __attribute__((vector_size(64), aligned(8), may_alias));
};

struct FourSingles {
  typedef float Register __attribute__((vector_size(16), aligned(4), may_alias));
};
struct EightSingles {
  typedef float Register __attribute__((vector_size(32), aligned(4), may_alias));
};
struct SixteenSingles {
  typedef float Register __attribute__((vector_size(64), aligned(4), may_alias));
};

}  // namespace plica
