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
#include "raster/field/residual_codebook.h"

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

// Writes a Compact-3DGS model in each of its three forms, which compact_model.h describes, with the
// arrays and names of the published program, so that it reads them too.

/// The codes of all Gaussians: one of each layer, Gaussian by Gaussian.
struct CodedVectors {
  ResidualCodebook codebook;
  std::vector<std::uint16_t> numbers;
};

/// Writes point_cloud.ply, for example, and point_cloud.pth beside it. Values are written as they
/// are. `trained`: the file says that this program trained the model. Throws Error(input).
void write_compact_ply(const CompactModel& model, const std::filesystem::path& path,
                       bool trained = false);

/// Writes an activated model. Scales and rotations are written as codes; model.scales and
/// model.rotations are not used. Positions, opacities and the field are rounded to half precision.
/// Throws Error(input).
void write_compact_npz(const CompactModel& model, const CodedVectors& scales,
                       const CodedVectors& rotations, const std::filesystem::path& path);

/// As write_compact_npz(), with opacities and the hash grid in 8 bits, and Huffman codes. Values of
/// the grid that are not beyond 0.1 become 0, as in the published program. Throws Error(input).
void write_compact_processed(const CompactModel& model, const CodedVectors& scales,
                             const CodedVectors& rotations, const std::filesystem::path& path);

/// Values in 256 equal steps from the least to the largest.
struct QuantisedValues {
  float low = 0, high = 0;
  std::vector<std::uint16_t> numbers;  ///< 0..255

  float value(std::size_t i) const;
};

/// Values of at most `most_zero` count as 0 after the bounds were found.
QuantisedValues quantise(std::span<const float> values, float most_zero);

}  // namespace qs
