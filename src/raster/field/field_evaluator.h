// SPDX-License-Identifier: MIT
//
// Evaluates a colour field for many Gaussians, in single precision and in vectors, with parameters
// rounded to half precision as the published files hold them. tiny-cuda-nn keeps all intermediate
// values in half precision too: its features differ by up to 6e-4 and its outputs by up to 3e-4.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "raster/field/color_field.h"

namespace qs {

// Spherical harmonics of degree 3 from values in 24 directions. The directions are a spherical
// 7-design (Hardin and Sloane, McLaren's Improved Snub Cube, 1996): sums over them equal integrals
// over the sphere for polynomials up to degree 7. So the projection is exact for functions up to
// degree 4, and for others it is the least-squares fit to the 24 values.

inline constexpr int kDesignSize = 24;

/// Unit vectors: the orbit of one vector under the 24 rotations of the cube.
std::array<glm::dvec3, kDesignSize> design_directions();

/// weights[j][i]: coefficient i is the sum over all j of weights[j][i] times the value in direction
/// j, and the fitted value in direction j is the sum over i of basis[j][i] times coefficient i.
struct ShDesign {
  std::array<std::array<float, 16>, kDesignSize> weights, basis;
};

ShDesign sh_design();

namespace field_vectors {

inline constexpr std::size_t kRows = 8;  ///< outputs of a layer that are computed together
/// Rows of the last layer: three outputs, and zeros.
inline constexpr std::size_t kOutRows = 4;

/// The parameters of a ColorField in the order of the loops.
struct Packed {
  std::vector<GridLevel> levels;
  std::vector<std::uint32_t> entries;  ///< both features of an entry as halves, the first below
  std::size_t width = 0;
  // Matrices have (outputs / kRows, inputs, kRows) values.
  std::vector<float> from_grid;       ///< first layer, columns of the grid's features
  std::vector<float> from_direction;  ///< first layer, columns of the direction's features
  std::vector<float> bias;            ///< first layer, sums of the columns of ones; (width)
  std::vector<float> hidden;          ///< second layer
  std::vector<float> last;            ///< third layer, with kOutRows rows in one block
  std::vector<float> of_design;       ///< first layer's part of each design direction, with bias:
                                      ///< (kDesignSize, width)
  ShDesign design;
};

}  // namespace field_vectors

class FieldEvaluator {
 public:
  explicit FieldEvaluator(const ColorField& field);

  /// The network's three outputs per mean, for the direction from `eye` to it. They are SH
  /// coefficients of degree 0: the colour is max(0, kSh0 * output + 0.5). Spans have equal sizes.
  /// Threads may call this at the same time.
  void outputs(std::span<const glm::vec3> means, const glm::vec3& eye,
               std::span<glm::vec3> out) const;

  /// Spherical harmonics of degree 3 of the colours, as a GaussianCloud holds them: 16 triples per
  /// mean, from 24 directions. `rms` receives each mean's root of the mean square of the difference
  /// between both in these directions, of all three channels, in units of 0..1. Threads may call
  /// this at the same time.
  void fit_sh(std::span<const glm::vec3> means, std::span<glm::vec3> sh,
              std::span<float> rms) const;

 private:
  field_vectors::Packed packed_;
};

}  // namespace qs
