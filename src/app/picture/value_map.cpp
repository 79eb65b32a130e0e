// SPDX-License-Identifier: MIT
#include "app/picture/value_map.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "app/picture/legend.h"
#include "app/picture/palette.h"
#include "base/fail.h"
#include "base/list_of.h"
#include "base/rank.h"

namespace qs {
namespace {

constexpr double kSteps = 65535;

}  // namespace

std::vector<std::string> quantity_names() {
  return list_of<std::string>(kQuantities, &QuantityRow::name);
}

std::vector<float> ValueScale::ticks() const {
  std::vector<float> result;
  const long steps = std::lround((high - low) / step);
  for (long i = 0; i <= steps; ++i) result.push_back(low + static_cast<float>(i) * step);
  return result;
}

std::string ValueScale::text(float value) const {
  const int decimals = std::max(0, -static_cast<int>(std::floor(std::log10(step) + 1e-3f)));
  return fmt::format("{:.{}f}", value, decimals);
}

std::string ValueScale::text_of_ends() const {
  return fmt::format("{} to {}", text(low), text(high));
}

ValueScale scale_for(Quantity quantity, std::span<const float> values) {
  if (quantity == Quantity::alpha) return {};
  std::vector<float> drawn;
  std::ranges::copy_if(values, std::back_inserter(drawn),
                       [](float value) { return value > 0 && std::isfinite(value); });
  if (drawn.empty()) return {};
  const std::size_t beyond = drawn.size() / 200;
  const double least = static_cast<double>(at_rank(drawn, beyond));
  const double most = static_cast<double>(at_rank(drawn, drawn.size() - 1 - beyond));
  constexpr int kMostSteps = 8;
  const double reach = std::max(most - least, 1e-3 * most);
  const double step = round_step(0.1 * reach, [&](double size) {
    return std::ceil(most / size) - std::floor(least / size) <= kMostSteps;
  });
  const double low = std::floor(least / step), high = std::max(std::ceil(most / step), low + 1);
  return {static_cast<float>(low * step), static_cast<float>(high * step),
          static_cast<float>(step)};
}

Outputs outputs_for(Quantity quantity) { return {.depth = quantity != Quantity::color}; }

ValueMap map_of(const Frame& frame, Quantity quantity, int width, int height) {
  const std::vector<float>& values = frame.depth.*row_of(quantity).values;
  return {quantity, width, height, values, scale_for(quantity, values)};
}

Image values_of(const ValueMap& map) {
  Image image(map.width, map.height, 1);
  image.values = map.values;
  return image;
}

Legend make_legend(const ValueMap& map, const char* mode) {
  const ValueScale& scale = map.scale;
  const bool is_depth = map.quantity != Quantity::alpha;
  Legend legend;
  legend.title = row_of(map.quantity).title;
  legend.facts = fmt::format("mode {} \u00b7 {}", mode,
                             is_depth ? "units of the scene along the view axis, from the camera"
                                      : "1 = nothing behind the Gaussians is seen");
  for (const float value : scale.ticks())
    legend.ticks.push_back({(value - scale.low) / (scale.high - scale.low), scale.text(value)});
  legend.ticks.back().text += row_of(map.quantity).unit;
  legend.color = viridis;
  return legend;
}

Image colored(const ValueMap& map) {
  Image image(map.width, map.height, 3);
  const float range = map.scale.high - map.scale.low;
  for (std::size_t i = 0; i < map.values.size(); ++i) {
    const float value = map.values[i];
    const glm::vec3 shown =
        value > 0 ? viridis((value - map.scale.low) / range) : heat_of_zero(0.5f);
    for (int c = 0; c < 3; ++c) image.values[3 * i + static_cast<std::size_t>(c)] = shown[c];
  }
  return image;
}

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
  if (picture_extension(path) != ".png") {
    metadata["Values"] = is_depth ? "units" : "0 to 1";
    metadata[kChannelText] = is_depth ? "Z" : "A";
    write_image(image, path, metadata, progress);
    return metadata["Values"];
  }
  if (!is_depth) {
    metadata["Values"] = "steps of 1/65535";
  } else {
    const float largest = map.values.empty() ? 0 : std::ranges::max(map.values);
    const double needed = depth_step_for(largest), chosen = step.value_or(needed);
    if (static_cast<double>(largest) > kSteps * chosen)
      fail(ErrorKind::usage,
           "{}: 16 bits reach {:.6g} units in steps of {:.6g}, but the picture's depth reaches "
           "{:.6g}: steps of {:.6g} do",
           path.string(), kSteps * chosen, chosen, largest, needed);
    for (float& value : image.values)
      value = static_cast<float>(static_cast<double>(value) / (kSteps * chosen));
    metadata["UnitsPerStep"] = fmt::format("{:.6g}", chosen);
    metadata["Values"] = fmt::format("steps of {:.6g} units", chosen);
  }
  write_16_bit_png(image, path, metadata, progress);
  return metadata["Values"];
}

}  // namespace qs
