// SPDX-License-Identifier: MIT
//
// Random arguments of functions as lists of numbers, for gradient tests.
#pragma once

#include <random>
#include <vector>

#include <glm/vec3.hpp>

#include "raster/kernel/project.h"

namespace qs::test {

inline constexpr int kDraws = 50;

class Draws {
 public:
  explicit Draws(unsigned seed) : random_(seed) {}

  double uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }
  std::vector<double> uniform(std::size_t count, double low, double high) {
    std::vector<double> values(count);
    for (double& value : values) value = uniform(low, high);
    return values;
  }

 private:
  std::mt19937 random_;
};

template <class Real>
glm::vec<3, Real> vec3(const std::vector<Real>& x, std::size_t at = 0) {
  return {x[at], x[at + 1], x[at + 2]};
}

template <class Real>
std::vector<Real> list(const glm::vec<3, Real>& v) {
  return {v.x, v.y, v.z};
}

template <class Real>
std::vector<Real> list(const Covariance2<Real>& c) {
  return {c.xx, c.xy, c.yy};
}

template <class Real>
std::vector<Real> list(const Covariance3<Real>& c) {
  return {c.xx, c.xy, c.xz, c.yy, c.yz, c.zz};
}

template <class Real>
void append(std::vector<Real>& list, const std::vector<Real>& more) {
  list.insert(list.end(), more.begin(), more.end());
}

inline double dot(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += a[i] * b[i];
  return sum;
}

template <class Real>
std::vector<Real> rounded(const std::vector<double>& values) {
  return std::vector<Real>(values.begin(), values.end());
}

}  // namespace qs::test
