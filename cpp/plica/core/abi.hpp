#pragma once
// What an embedder must compile with as the library was: objects of the standard library and of Eigen cross the
// border, so both sides must lay them out, allocate and free them alike. Eigen's settings are held against what
// CMake sets; where the library could be built in more than one way, a program refers to a name that only a
// library built as the program is defines, and the linker says which one it misses.
#include <Eigen/Core>
#include <cstddef>
#include <string>
#include <type_traits>

static_assert(
    EIGEN_DEFAULT_ALIGN_BYTES == 64 && EIGEN_MAX_STATIC_ALIGN_BYTES == 16 && EIGEN_MALLOC_ALREADY_ALIGNED == 0 &&
        std::is_same_v<Eigen::Index, std::ptrdiff_t>,
    "plica: Eigen allocates here otherwise than in the library. Link plica's CMake targets, or compile "
    "every source that uses Eigen with -DEIGEN_MAX_ALIGN_BYTES=64 -DEIGEN_MAX_STATIC_ALIGN_BYTES=16, and "
    "define no other EIGEN_ macro that says how memory is aligned or indexed.");
static_assert(!Eigen::MatrixXd::IsRowMajor,
              "plica: Eigen's matrices have another storage order here than in the library. Do not define "
              "EIGEN_DEFAULT_TO_ROW_MAJOR.");
static_assert(
    sizeof(Eigen::MatrixXd) == 3 * sizeof(void*) && sizeof(Eigen::VectorXd) == 2 * sizeof(void*) &&
        sizeof(Eigen::Vector3d) == 3 * sizeof(double),
    "plica: Eigen's matrices have other members here than in the library. Define no EIGEN_..._PLUGIN that "
    "adds any.");

// The settings by name: containers that check themselves are larger, strings have had two layouts, and Eigen's
// inline functions, of which the linker keeps one copy for both sides, change with its version.
// _GLIBCXX_ASSERTIONS and NDEBUG change no layout.
#define PLICA_JOIN(a, b) a##b
#define PLICA_JOINED(a, b) PLICA_JOIN(a, b)
#if defined(_LIBCPP_VERSION)
#define PLICA_STANDARD_LIBRARY PLICA_JOINED(standard_library_is_libcxx_ABI_, _LIBCPP_ABI_VERSION)
#elif defined(_GLIBCXX_USE_CXX11_ABI) && _GLIBCXX_USE_CXX11_ABI
#define PLICA_STANDARD_LIBRARY built_with_GLIBCXX_USE_CXX11_ABI_1
#elif defined(__GLIBCXX__)
#define PLICA_STANDARD_LIBRARY built_with_GLIBCXX_USE_CXX11_ABI_0
#else
#define PLICA_STANDARD_LIBRARY standard_library_is_neither_libstdcxx_nor_libcxx
#endif
#if defined(_GLIBCXX_DEBUG)
#define PLICA_CONTAINERS built_with_GLIBCXX_DEBUG
#else
#define PLICA_CONTAINERS built_without_GLIBCXX_DEBUG
#endif
#define PLICA_EIGEN                     \
  PLICA_JOINED(                         \
      built_with_Eigen_,                \
      PLICA_JOINED(EIGEN_WORLD_VERSION, \
                   PLICA_JOINED(_, PLICA_JOINED(EIGEN_MAJOR_VERSION, PLICA_JOINED(_, EIGEN_MINOR_VERSION)))))

namespace plica::the_library_must_be {

extern const char PLICA_STANDARD_LIBRARY, PLICA_CONTAINERS, PLICA_EIGEN;
/// A reference from every source, which no optimisation drops.
[[gnu::used]] static const char* const as_here[] = {&PLICA_STANDARD_LIBRARY, &PLICA_CONTAINERS, &PLICA_EIGEN};

}  // namespace plica::the_library_must_be
