// SPDX-License-Identifier: MIT
#include "learn/step/relocation.h"

#include <cmath>

namespace qs::train {
namespace {

double binomial(int n, int k) {
  double value = 1;
  for (int i = 1; i <= k; ++i) value = value * (n - k + i) / i;
  return value;
}

}  // namespace

Relocation relocated(double opacity, int copies) {
  const double after = 1 - std::pow(1 - opacity, 1.0 / copies);
  double sum = 0;
  for (int n = 1; n <= copies; ++n)
    for (int k = 0; k < n; ++k)
      sum +=
          binomial(n - 1, k) * (k % 2 == 0 ? 1 : -1) * std::pow(after, k + 1) / std::sqrt(k + 1.0);
  const double factor = opacity / sum;
  return {after, factor > 0 && std::isfinite(factor) ? factor : 1};
}

}  // namespace qs::train
