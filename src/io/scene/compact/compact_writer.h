// SPDX-License-Identifier: MIT
//
// Writes a Compact-3DGS model in each of its three forms, which compact_model.h describes, with the
// arrays and names of the published program, so that it reads them too.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "io/scene/compact/compact_model.h"
#include "raster/field/residual_codebook.h"

namespace qs {

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
