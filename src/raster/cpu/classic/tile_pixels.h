// SPDX-License-Identifier: MIT
//
// The pixels of a tile for passes that composite them again after the blend stage.
#pragma once

#include <algorithm>
#include <array>

#include "raster/cpu/classic/bin.h"
#include "raster/kernel/composite.h"

namespace qs::cpu {

/// The pixels of a tile that are inside the image. Coordinates start at the tile's corner.
struct TilePixels {
  static constexpr int kMostPx = kTileSizes.back();

  int x0, y0;                                          ///< the corner, in the image
  int width, height, live;                             ///< live: pixels that have not stopped
  std::array<float, kMostPx * kMostPx> transmittance;  ///< row by row; 0 = stopped

  TilePixels(const FrameContext& frame, std::size_t tile)
      : x0(static_cast<int>(tile) % frame.grid.columns * frame.grid.tile_px),
        y0(static_cast<int>(tile) / frame.grid.columns * frame.grid.tile_px),
        width(std::min(frame.grid.tile_px, frame.camera.width - x0)),
        height(std::min(frame.grid.tile_px, frame.camera.height - y0)),
        live(width * height) {
    transmittance.fill(1);
  }

  /// Composites a Gaussian and calls blended(x, y, alpha, transmittance behind it) for the pixels
  /// that blend it.
  template <class Blended>
  void composite(const BoundedSplat& bounded, const Blended& blended) {
    const auto left = static_cast<float>(x0), top = static_cast<float>(y0);
    const glm::vec2 half = bounded.bound.half, mean = bounded.splat.mean_px - glm::vec2(left, top);
    const Span columns{clamp_to_int(mean.x - half.x, width),
                       clamp_to_int(mean.x + half.x + 1, width)};
    const Span rows{clamp_to_int(mean.y - half.y, height),
                    clamp_to_int(mean.y + half.y + 1, height)};
    for (int y = rows.begin; y < rows.end; ++y) {
      for (int x = columns.begin; x < columns.end; ++x) {
        float& behind = transmittance[static_cast<std::size_t>(y * width + x)];
        if (behind == 0) continue;
        float alpha = 0;
        const Step step = qs::composite(bounded.splat, left + static_cast<float>(x),
                                        top + static_cast<float>(y), behind, alpha);
        if (step == Step::blends) blended(x, y, alpha, behind);
        if (step == Step::stops) {
          behind = 0;
          --live;
        }
      }
    }
  }
};

}  // namespace qs::cpu
