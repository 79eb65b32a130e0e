// SPDX-License-Identifier: MIT
//
// Compares gradients that were derived by hand with differences of the function in double
// precision.
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include <gtest/gtest.h>

namespace qs::test {

/// The gradient of `loss` at `x` by central differences of fourth order. `step` is relative to
/// 1 + |x|.
inline std::vector<double> differences(
    const std::function<double(const std::vector<double>&)>& loss, const std::vector<double>& x,
    double step = 1e-4) {
  std::vector<double> result;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double h = step * (1 + std::abs(x[i]));
    const auto at = [&](double offset) {
      std::vector<double> moved = x;
      moved[i] += offset;
      return loss(moved);
    };
    result.push_back((8 * (at(h) - at(-h)) - (at(2 * h) - at(-2 * h))) / (12 * h));
  }
  return result;
}

/// Expects that all values agree up to `tolerance` times the largest expected one.
template <class Real>
void expect_close(const std::vector<Real>& values, const std::vector<double>& expected,
                  double tolerance) {
  ASSERT_EQ(values.size(), expected.size());
  double scale = 0;
  for (const double value : expected) scale = std::max(scale, std::abs(value));
  for (std::size_t i = 0; i < values.size(); ++i) {
    EXPECT_NEAR(static_cast<double>(values[i]), expected[i], tolerance * scale) << "value " << i;
  }
}

/// Checks gradient(std::vector<Real>) in both precisions against differences of loss(x).
template <class Gradient>
void expect_gradient(const std::function<double(const std::vector<double>&)>& loss,
                     const std::vector<double>& x, const Gradient& gradient) {
  const std::vector<double> expected = differences(loss, x);
  expect_close(gradient(x), expected, 1e-6);
  expect_close(gradient(std::vector<float>(x.begin(), x.end())), expected, 1e-3);
}

}  // namespace qs::test
