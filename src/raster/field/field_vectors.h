// SPDX-License-Identifier: MIT
//
// The inner loops of field_evaluator.h, in vectors of Gaussians. Instruction sets without fused
// multiply-add differ in the last bits.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "raster/field/sh_design.h"
#include "raster/kernel/color_field.h"

namespace qs::field_vectors {

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

/// Outputs of the network for each mean seen from `eye`.
void outputs(const Packed& packed, std::span<const glm::vec3> means, const glm::vec3& eye,
             glm::vec3* out);

/// SH coefficients of degree 3, 16 per mean, and the rms difference of each mean's colour values.
void fit(const Packed& packed, std::span<const glm::vec3> means, glm::vec3* sh, float* rms);

}  // namespace qs::field_vectors
