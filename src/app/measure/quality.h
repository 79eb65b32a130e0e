// SPDX-License-Identifier: MIT
//
// The image quality of a renderer on one view: against the fp64 reference, and against itself.
#pragma once

#include "app/measure/bench_row.h"
#include "raster/api/renderer.h"

namespace qs {

struct FrameQuality {
  double psnr = 0;       ///< dB, psnr_8bit()
  double ssim = 0;       ///< of values clamped to 0..1
  double flip = 0;       ///< of values clamped to 0..1
  bool repeats = false;  ///< two frames are equal to the bit
};

/// Renders the view twice and compares the images. Throws what the renderer throws.
FrameQuality quality_of(Renderer& renderer, const Camera& camera, const RenderSettings& settings,
                        const Image& truth, ThreadPool& pool);

/// Sets the columns of a row.
void set_quality(const FrameQuality& quality, BenchRow& row);

}  // namespace qs
