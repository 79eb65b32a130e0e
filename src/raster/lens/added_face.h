// SPDX-License-Identifier: MIT
//
// The addition of a face to a picture, once for g++ and nvcc, so that backends give the same bits
// for equal faces.
#pragma once

#include <cstddef>
#include <cstdint>

#include "raster/api/renderer.h"
#include "raster/lens/lens_map.h"
#include "raster/scene/cubic_taps.h"

namespace qs {

/// The maps of a picture that is added up; null where they are not wanted.
struct SummedMaps {
  float* color = nullptr;                                          ///< height x width x 3
  float *alpha = nullptr, *expected = nullptr, *median = nullptr;  ///< see DepthMaps

  SummedMaps from(std::size_t pixel) const {
    SummedMaps maps = *this;
    if (color != nullptr) maps.color += 3 * pixel;
    if (alpha != nullptr) {
      maps.alpha += pixel;
      maps.expected += pixel;
      maps.median += pixel;
    }
    return maps;
  }
};

/// A drawn face, and the picture to which it is added.
struct AddedFace {
  DeviceMaps face;  ///< of the memory of the picture
  int width;        ///< of the face
  SummedMaps picture;
  const std::uint8_t* nearest;  ///< LensMap::nearest
  std::uint8_t number;          ///< of the face in it

  QS_HD void add(const FacePixel& pixel) const {
    const std::size_t at = pixel.pixel;
    if (picture.color != nullptr) {
      float color[3] = {};
      interpolate<3>(face.color, pixel, color);
      for (int c = 0; c < 3; ++c) picture.color[3 * at + c] += pixel.weight * color[c];
    }
    if (picture.alpha == nullptr) return;
    float alpha = 0;
    interpolate<1>(face.alpha, pixel, &alpha);
    picture.alpha[at] += pixel.weight * (alpha < 0 ? 0 : alpha > 1 ? 1 : alpha);
    if (nearest[at] != number) return;
    const std::size_t source =
        static_cast<std::size_t>(pixel.y + 0.5f) * width + static_cast<std::size_t>(pixel.x + 0.5f);
    picture.expected[at] = face.expected[source];
    picture.median[at] = face.median[source];
  }

 private:
  // The sum of four columns of four rows.
  template <int kChannels>
  QS_HD void interpolate(const float* values, const FacePixel& at, float* result) const {
    const CubicTaps across = cubic_taps(double{at.x}), down = cubic_taps(double{at.y});
    float columns[4 * kChannels] = {};
    for (int row = 0; row < 4; ++row) {
      const float* const from =
          values +
          (static_cast<std::ptrdiff_t>(down.first + row) * width + across.first) * kChannels;
      for (int k = 0; k < 4 * kChannels; ++k) columns[k] += down.weights[row] * from[k];
    }
    for (int column = 0; column < 4; ++column)
      for (int c = 0; c < kChannels; ++c)
        result[c] += across.weights[column] * columns[column * kChannels + c];
  }
};

}  // namespace qs
