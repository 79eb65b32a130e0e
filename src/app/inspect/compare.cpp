// SPDX-License-Identifier: MIT
#include "app/inspect/compare.h"

#include <algorithm>
#include <cstdlib>

#include "io/picture/image_file.h"
#include "raster/base/fail.h"

namespace qs {

Comparison compare(const Image& rendered, const Image& reference) {
  constexpr int kMostAmplification = 64;
  Comparison result;
  result.psnr = psnr_8bit(rendered, reference);
  result.difference = Image(rendered.width, rendered.height, 3);
  for (int y = 0; y < rendered.height; ++y) {
    for (int x = 0; x < rendered.width; ++x) {
      for (int c = 0; c < 3; ++c) {
        const int difference =
            std::abs(to_8bit(rendered.at(x, y, c)) - to_8bit(reference.at(x, y, c)));
        result.largest = std::max(result.largest, difference);
        result.difference.at(x, y, c) = static_cast<float>(difference) / 255;
      }
    }
  }
  // As bright as possible without clipping.
  result.amplification = std::clamp(255 / std::max(result.largest, 1), 1, kMostAmplification);
  for (float& value : result.difference.values) value *= static_cast<float>(result.amplification);
  return result;
}

Image read_reference(const std::filesystem::path& path, int width, int height) {
  Image image = read_image(path);
  if (image.width != width || image.height != height) {
    fail("{}: is {} x {} pixels, but the frame is {} x {}", path.string(), image.width,
         image.height, width, height);
  }
  if (image.channels >= 3) return image;
  Image rgb(width, height, 3);  // gray, with or without alpha
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      for (int c = 0; c < 3; ++c) rgb.at(x, y, c) = image.at(x, y, 0);
    }
  }
  return rgb;
}

std::filesystem::path difference_path(const std::filesystem::path& output) {
  std::filesystem::path result = output;
  return result.replace_extension("").concat(".difference.png");
}

}  // namespace qs
