// SPDX-License-Identifier: MIT
//
// Spherical harmonics of degree 3 from values in 24 directions. The directions are a spherical
// 7-design (Hardin and Sloane, McLaren's Improved Snub Cube, 1996): sums over them equal integrals
// over the sphere for polynomials up to degree 7. So the projection is exact for functions up to
// degree 4, and for others it is the least-squares fit to the 24 values.
#pragma once

#include <array>

#include <glm/vec3.hpp>

namespace qs {

inline constexpr int kDesignSize = 24;

/// Unit vectors: the orbit of one vector under the 24 rotations of the cube.
std::array<glm::dvec3, kDesignSize> design_directions();

/// weights[j][i]: coefficient i is the sum over all j of weights[j][i] times the value in direction
/// j, and the fitted value in direction j is the sum over i of basis[j][i] times coefficient i.
struct ShDesign {
  std::array<std::array<float, 16>, kDesignSize> weights, basis;
};

ShDesign sh_design();

}  // namespace qs
