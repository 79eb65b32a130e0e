// SPDX-License-Identifier: MIT
#include "raster/scene/image.h"

#include <cassert>

#include "raster/scene/image_metrics.h"

namespace qs {

double psnr_8bit(const Image& a, const Image& b, int channels) {
  assert(a.width == b.width && a.height == b.height);
  assert(a.channels >= channels && b.channels >= channels);
  double squared_sum = 0;
  for (int y = 0; y < a.height; ++y) {
    for (int x = 0; x < a.width; ++x) {
      for (int c = 0; c < channels; ++c) {
        const double difference = to_8bit(a.at(x, y, c)) - to_8bit(b.at(x, y, c));
        squared_sum += difference * difference;
      }
    }
  }
  return psnr_of(squared_sum / (static_cast<double>(a.width) * a.height * channels), 255);
}

}  // namespace qs
