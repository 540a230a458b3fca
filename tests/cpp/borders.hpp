#pragma once
// A public function called with arrays that are too short, too long or empty, and indices out of range: what it
// must refuse, for the tables of test_borders.cpp. Under sanitizers a call that is not refused is seen at the
// first entry that it reads or writes beyond an array. An argument is named "function parameter" or
// "Class::function parameter", of a struct "... parameter.member": tests/python/engine/test_cpp_borders.py misses
// those that are not there.
#include <doctest/doctest.h>

#include <functional>
#include <string>
#include <type_traits>
#include <vector>

#include "plica/core/error.hpp"

namespace borders {

/// Whether an array that is too long is refused, too, or what is beyond is not looked at.
enum class Longer { refused, unread };
/// Whether an empty array is refused, too, or stands for none.
enum class Empty { refused, none };

template <class T>
std::vector<T> resized(std::vector<T> array, std::ptrdiff_t size) {
  array.resize(static_cast<std::size_t>(size), array.empty() ? T{} : array.back());
  return array;
}
template <class Array>
auto resized(const Array& array, std::ptrdiff_t size) -> decltype(array.rows(), Array(array)) {
  Array other(size, array.cols());
  for (std::ptrdiff_t i = 0; i < size; ++i) other.row(i) = array.row(std::min(i, array.rows() - 1));
  return other;
}
template <class T>
std::ptrdiff_t rows_of(const std::vector<T>& array) {
  return static_cast<std::ptrdiff_t>(array.size());
}
template <class Array>
auto rows_of(const Array& array) -> decltype(array.rows()) {
  return array.rows();
}

/// The call, as it stands, is refused.
inline void refused(const char* argument, const std::function<void()>& call) {
  CAPTURE(std::string(argument));
  CHECK_THROWS_AS(call(), plica::InvalidInput);
}

/// The call, as it stands, is answered; with this argument of it short, long or empty it is refused.
template <class Array>
void sizes(const char* argument, Array& array, const std::function<void()>& call, Longer longer = Longer::refused,
           Empty empty = Empty::refused) {
  CAPTURE(std::string(argument));
  const Array good = array;
  const std::ptrdiff_t n = rows_of(good);
  REQUIRE(n > 0);
  CHECK_NOTHROW(call());
  for (const std::ptrdiff_t size : {std::ptrdiff_t{0}, n - 1, n + 1, 2 * n + 7}) {
    CAPTURE(size);
    array = resized(good, size);
    if ((size > n && longer == Longer::unread) || (size == 0 && empty == Empty::none))
      CHECK_NOTHROW(call());
    else
      CHECK_THROWS_AS(call(), plica::InvalidInput);
  }
  array = good;
}

/// With an index out of range, first or last of the array, it is refused.
template <class Array>
void indices(const char* argument, Array& array, const std::function<void()>& call) {
  CAPTURE(std::string(argument));
  const Array good = array;
  REQUIRE(array.size() > 0);
  CHECK_NOTHROW(call());
  for (const std::int32_t wrong : {-1, 1 << 30, -(1 << 30)})
    for (const std::ptrdiff_t at : {std::ptrdiff_t{0}, static_cast<std::ptrdiff_t>(good.size()) - 1}) {
      CAPTURE(wrong);
      array.data()[at] = wrong;
      CHECK_THROWS_AS(call(), plica::InvalidInput);
      array = good;
    }
}

/// A number that must be in a range, with some that are not.
template <class Number>
void numbers(const char* argument, Number& number, std::initializer_list<Number> wrong,
             const std::function<void()>& call) {
  CAPTURE(std::string(argument));
  const Number good = number;
  CHECK_NOTHROW(call());
  for (const Number value : wrong) {
    CAPTURE(value);
    number = value;
    CHECK_THROWS_AS(call(), plica::InvalidInput);
  }
  number = good;
}

}  // namespace borders
