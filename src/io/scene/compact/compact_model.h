// SPDX-License-Identifier: MIT
//
// A Compact-3DGS model as its files hold it. It has three forms: a .ply of the Gaussians beside a
// .pth of the colour field; an .npz with codes of scales and rotations (compact_npz.cpp); and an
// .npz whose opacities, codes and hash grid are Huffman codes too, called "post-processed".
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include <glm/gtc/quaternion.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include "base/progress.h"
#include "io/bytes/byte_text.h"
#include "io/cloud/scene.h"
#include "raster/field/color_field.h"

namespace qs {

struct CompactModel {
  // One entry per Gaussian.
  std::vector<glm::vec3> means;
  std::vector<glm::vec3> scales;     ///< if activated standard deviations of any sign, else their
                                     ///< logarithms
  std::vector<glm::vec4> rotations;  ///< w, x, y, z, of any length; if activated used as they are
  std::vector<float> opacities;      ///< if activated 0..1, else logits
  // Final models hold opacities and scales, the models of earlier iterations what is trained. The
  // first release of Compact-3DGS left logits in final models.
  bool activated_opacities = true, activated_shapes = true;
  ColorField field;

  std::string form;             ///< the files' kind, for Scene::format
  std::vector<FilePart> parts;  ///< parts of the files
  std::uint64_t file_bytes = 0;
  std::vector<std::string> warnings;  ///< whole sentences
};

/// The form of a .ply, whose .pth lies beside it. Throws Error(input), Cancelled.
CompactModel read_compact_ply(ByteSpan content, const std::filesystem::path& path,
                              const Progress& progress);

/// Either form of an .npz. Throws Error(input), Cancelled.
CompactModel read_compact_npz(ByteSpan content, const std::filesystem::path& path,
                              const Progress& progress);

/// The field with these parameters. Files do not state its shape: the number of values determines
/// the entries of a level. Throws Error(input) if no field has these numbers of parameters.
ColorField make_color_field(std::vector<float> grid_values, std::vector<float> weights,
                            const std::string& source);

// Gaussians whose quaternion is used as it is stored, of a length that is not 1. The published
// renderers of 3DGS build a matrix from it that is no rotation: for q = s u with a unit u it is
// (1 - s^2) I + s^2 R(u).

struct ShapeOfGaussian {
  glm::quat rotation{1, 0, 0, 0};  ///< unit
  glm::vec3 log_scale{0};          ///< -inf = flat
};

/// The rotation and the scales with the covariance that `quaternion` (w, x, y, z) and the standard
/// deviations `scale`, of any sign, give in these renderers. If a value is infinite or NaN, so is
/// the rotation.
ShapeOfGaussian shape_of_raw_rotation(const glm::vec4& quaternion, const glm::vec3& scale);

}  // namespace qs
