#pragma once
#include <cmath>
#include <random>

#include "plica/imaging/plane.hpp"

/// A smooth texture known at every place: waves of 7 to 50 px, grey levels about 128 +- 60.
class Texture {
 public:
  explicit Texture(unsigned seed = 1) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> uniform(-1, 1);
    double frequency = 0.9;
    for (auto& wave : waves_) {
      const double direction = 3.2 * uniform(random);
      wave[0] = frequency * std::cos(direction);
      wave[1] = frequency * std::sin(direction);
      wave[2] = 3.2 * uniform(random);
      frequency *= 0.8;
    }
  }

  double operator()(double x, double y) const {
    double sum = 0;
    for (const auto& wave : waves_) sum += std::sin(wave[0] * x + wave[1] * y + wave[2]);
    return 128 + 25 * sum;
  }

  /// What a camera sees of it when it has moved by (u, v).
  plica::imaging::Plane picture(std::ptrdiff_t rows, std::ptrdiff_t columns, double u = 0, double v = 0) const {
    plica::imaging::Plane result(rows, columns);
    for (std::ptrdiff_t y = 0; y < rows; ++y) {
      for (std::ptrdiff_t x = 0; x < columns; ++x) {
        result(y, x) = static_cast<float>((*this)(static_cast<double>(x) - u, static_cast<double>(y) - v));
      }
    }
    return result;
  }

 private:
  double waves_[10][3];
};

/// Values of [-size, size).
inline plica::imaging::Plane noise(std::ptrdiff_t rows, std::ptrdiff_t columns, float size, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> uniform(-size, size);
  plica::imaging::Plane result(rows, columns);
  for (auto& value : result.reshaped()) value = uniform(random);
  return result;
}
