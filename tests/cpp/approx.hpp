#pragma once
#include <doctest/doctest.h>

#include <limits>

/// As doctest::Approx, whose epsilon is of the values alone: that of doctest allows as much again in units, and so
/// finds any two small numbers equal. Zero is equal to zero alone.
inline doctest::Approx approx(double value) {
  return doctest::Approx(value).scale(std::numeric_limits<double>::min());
}
