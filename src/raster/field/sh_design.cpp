// SPDX-License-Identifier: MIT
#include "raster/field/sh_design.h"

#include <cmath>
#include <cstddef>

#include <glm/gtc/constants.hpp>

#include "raster/kernel/sh.h"

namespace qs {
namespace {

// The squares of the components are the roots of z^3 - z^2 + z/5 - 1/105, by the cosine formula for
// three real roots, in ascending order.
glm::dvec3 first_direction() {
  const double p = -2.0 / 15, q = -2.0 / 27 + 1.0 / 15 - 1.0 / 105;
  const double angle = std::acos(1.5 * q / p * std::sqrt(-3 / p)) / 3;
  const auto root = [&](int k) {
    return 1.0 / 3 + 2 * std::sqrt(-p / 3) * std::cos(angle - k * 2 * glm::pi<double>() / 3);
  };
  return {std::sqrt(root(2)), std::sqrt(root(1)), std::sqrt(root(0))};
}

}  // namespace

std::array<glm::dvec3, kDesignSize> design_directions() {
  // A rotation of the cube permutes axes and turns some over: an even number if the permutation is
  // even, else an odd number.
  struct Permutation {
    std::array<int, 3> axes;
    bool odd;
  };
  constexpr std::array<Permutation, 6> kPermutations = {{{{0, 1, 2}, false},
                                                         {{1, 2, 0}, false},
                                                         {{2, 0, 1}, false},
                                                         {{0, 2, 1}, true},
                                                         {{2, 1, 0}, true},
                                                         {{1, 0, 2}, true}}};
  const glm::dvec3 first = first_direction();
  std::array<glm::dvec3, kDesignSize> directions;
  std::size_t next = 0;
  for (const Permutation& permutation : kPermutations) {
    for (int turned = 0; turned < 8; ++turned) {
      const bool odd = ((turned ^ turned >> 1 ^ turned >> 2) & 1) != 0;
      if (odd != permutation.odd) continue;
      for (int axis = 0; axis < 3; ++axis) {
        const double value = first[permutation.axes[static_cast<std::size_t>(axis)]];
        directions[next][axis] = (turned >> axis & 1) != 0 ? -value : value;
      }
      ++next;
    }
  }
  return directions;
}

ShDesign sh_design() {
  ShDesign design;
  const auto directions = design_directions();
  for (std::size_t j = 0; j < directions.size(); ++j) {
    std::array<double, 16> basis;
    sh_basis(directions[j], basis.data());
    for (std::size_t i = 0; i < basis.size(); ++i) {
      design.basis[j][i] = static_cast<float>(basis[i]);
      design.weights[j][i] = static_cast<float>(4 * glm::pi<double>() / kDesignSize * basis[i]);
    }
  }
  return design;
}

}  // namespace qs
