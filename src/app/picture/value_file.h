// SPDX-License-Identifier: MIT
//
// Files of alpha and depth. Floats hold the values themselves; a PNG holds steps of 1/65535 for
// alpha, and of a round number of units for depth.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "app/picture/value_map.h"
#include "io/picture/image_file.h"

namespace qs {

/// Throws Error(usage) unless the ending belongs to a format with floats or 16 bits. `who` begins
/// the sentence.
void require_value_file(const std::string& who, const std::filesystem::path& path,
                        Quantity quantity);

/// Units per step of a PNG that holds depths up to `largest`: 1, 2 or 5 times a power of ten.
double depth_step_for(float largest);

/// Writes the values. `step`: units per step of a PNG of depths; unset: depth_step_for() the
/// largest. Returns the unit of the file's values: "units", "steps of 0.0005 units". The metadata
/// contain the unit, and as `Picture` the quantity's name. Throws Error(usage) if the largest depth
/// has no step, and as write_image().
std::string write_values(const ValueMap& map, const std::filesystem::path& path,
                         std::optional<double> step, ImageMetadata metadata,
                         const Progress& progress = {});

}  // namespace qs
