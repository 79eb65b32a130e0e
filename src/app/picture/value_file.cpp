// SPDX-License-Identifier: MIT
#include "app/picture/value_file.h"

#include <algorithm>

#include "app/picture/scale.h"
#include "base/fail.h"

namespace qs {
namespace {

constexpr double kSteps = 65535;

bool is_png(const std::filesystem::path& path) { return picture_extension(path) == ".png"; }

float largest_of(const ValueMap& map) {
  return map.values.empty() ? 0 : *std::max_element(map.values.begin(), map.values.end());
}

}  // namespace

void require_value_file(const std::string& who, const std::filesystem::path& path,
                        Quantity quantity) {
  const std::string extension = picture_extension(path);
  for (const char* good : {".npy", ".exr", ".pfm", ".tif", ".tiff", ".png"})
    if (extension == good) return;
  fail(ErrorKind::usage,
       "{}: --picture {}: {} would keep 8 bits: use .npy, .exr, .pfm or .tif (floats), or .png (16 "
       "bits)",
       who, row_of(quantity).name, path.string());
}

double depth_step_for(float largest) {
  const double least = static_cast<double>(largest) / kSteps;
  if (!(least > 0)) return 0.001;
  return round_step(least, [least](double step) { return step >= least; });
}

std::string write_values(const ValueMap& map, const std::filesystem::path& path,
                         std::optional<double> step, ImageMetadata metadata,
                         const Progress& progress) {
  const bool is_depth = map.quantity != Quantity::alpha;
  metadata["Picture"] = row_of(map.quantity).name;
  Image image = values_of(map);
  if (!is_png(path)) {
    metadata["Values"] = is_depth ? "units" : "0 to 1";
    metadata[kChannelText] = is_depth ? "Z" : "A";
    write_image(image, path, metadata, progress);
    return metadata["Values"];
  }
  if (!is_depth) {
    metadata["Values"] = "steps of 1/65535";
  } else {
    const float largest = largest_of(map);
    const double needed = depth_step_for(largest), chosen = step.value_or(needed);
    if (static_cast<double>(largest) > kSteps * chosen) {
      fail(ErrorKind::usage,
           "{}: 16 bits reach {:.6g} units in steps of {:.6g}, but the picture's depth reaches "
           "{:.6g}: steps of {:.6g} do",
           path.string(), kSteps * chosen, chosen, largest, needed);
    }
    for (float& value : image.values)
      value = static_cast<float>(static_cast<double>(value) / (kSteps * chosen));
    metadata["UnitsPerStep"] = fmt::format("{:.6g}", chosen);
    metadata["Values"] = fmt::format("steps of {:.6g} units", chosen);
  }
  write_16_bit_png(image, path, metadata, progress);
  return metadata["Values"];
}

}  // namespace qs
