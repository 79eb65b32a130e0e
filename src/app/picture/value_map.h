// SPDX-License-Identifier: MIT
//
// Pictures of other quantities than colour: alpha and depth, as values and by a colour map, and
// their files. Floats hold the values themselves; a PNG holds steps of 1/65535 for alpha, and of a
// round number of units for depth. To add a quantity: a map in DepthMaps and a row in kQuantities.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "app/picture/legend.h"
#include "io/picture/image_file.h"
#include "raster/api/renderer.h"

namespace qs {

enum class Quantity { color, alpha, depth, median_depth };

struct QuantityRow {
  const char* name;   ///< the name that users type
  const char* title;  ///< the title of a legend
  const char* unit;   ///< the unit behind a number, "" for none
  std::vector<float> DepthMaps::*values;
};

/// Index = Quantity.
inline constexpr std::array kQuantities = {
    QuantityRow{"color", "Colour", "", nullptr},
    QuantityRow{"alpha", "Alpha: the share of the light that the Gaussians keep back", "",
                &DepthMaps::alpha},
    QuantityRow{"depth", "Expected depth: the mean of the Gaussians by weight", " units",
                &DepthMaps::expected},
    QuantityRow{"median-depth", "Median depth: the Gaussian behind which half the light is left",
                " units", &DepthMaps::median},
};

constexpr const QuantityRow& row_of(Quantity quantity) {
  return kQuantities[static_cast<std::size_t>(quantity)];
}

/// The names of kQuantities.
std::vector<std::string> quantity_names();

/// A range of values with round ends.
struct ValueScale {
  float low = 0, high = 1;  ///< multiples of step
  float step = 0.2f;        ///< 1, 2 or 5 times a power of ten

  std::vector<float> ticks() const;     ///< low, low + step, ..., high
  std::string text(float value) const;  ///< the value with the decimals of step
  std::string text_of_ends() const;     ///< "1.5 to 4"
};

struct ValueMap {
  Quantity quantity = Quantity::depth;  ///< not color
  int width = 0, height = 0;
  std::vector<float> values;  ///< row by row; 0 where nothing is drawn
  ValueScale scale;
};

/// For alpha: 0 to 1. For depths: four to eight steps (or fewer) that contain all values but 0.5 %
/// at each end; values of 0 do not count.
ValueScale scale_for(Quantity quantity, std::span<const float> values);

/// The outputs that map_of() needs.
Outputs outputs_for(Quantity quantity);

/// `frame` has width x height pixels and was rendered with outputs_for(quantity).
ValueMap map_of(const Frame& frame, Quantity quantity, int width, int height);

/// The values as an image of one channel.
Image values_of(const ValueMap& map);

/// The legend of colored(). `mode`: the culling mode that drew the map.
Legend make_legend(const ValueMap& map, const char* mode);

/// The values by a colour map, from dark violet (low) to yellow (high); dark gray for pixels
/// without Gaussians.
Image colored(const ValueMap& map);

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
