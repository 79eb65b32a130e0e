// SPDX-License-Identifier: MIT
#include "app/framing/principal_axes.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <glm/matrix.hpp>

namespace qs {

// Jacobi's method: every rotation zeroes one pair of off-diagonal entries, which shrink
// quadratically from sweep to sweep.
PrincipalAxes principal_axes(const glm::dmat3& matrix) {
  constexpr int kSweeps = 12;
  glm::dmat3 a = matrix, axes(1.0);
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    for (int p = 0; p < 2; ++p) {
      for (int q = p + 1; q < 3; ++q) {
        if (a[p][q] == 0) continue;
        const double apart = a[q][q] - a[p][p];
        const double angle =  // at most 45 degrees, which makes the sweeps converge
            0.5 *
            std::atan2(std::copysign(2 * a[p][q], a[p][q] * (apart < 0 ? -1 : 1)), std::abs(apart));
        glm::dmat3 turn(1.0);
        turn[p][p] = turn[q][q] = std::cos(angle);
        turn[q][p] = std::sin(angle);
        turn[p][q] = -turn[q][p];
        a = glm::transpose(turn) * a * turn;
        axes = axes * turn;
      }
    }
  }
  int order[3];
  std::iota(order, order + 3, 0);
  std::sort(order, order + 3, [&](int i, int j) { return a[i][i] < a[j][j]; });
  PrincipalAxes result;
  for (int i = 0; i < 3; ++i) {
    result.axis[i] = axes[order[i]];
    result.value[i] = a[order[i]][order[i]];
  }
  return result;
}

}  // namespace qs
