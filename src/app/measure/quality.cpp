// SPDX-License-Identifier: MIT
#include "app/measure/quality.h"

#include <cstring>

#include "raster/scene/flip.h"
#include "raster/scene/image_metrics.h"

namespace qs {
namespace {

bool equal_bits(const Image& a, const Image& b) {
  return a.values.size() == b.values.size() &&
         std::memcmp(a.values.data(), b.values.data(), a.values.size() * sizeof(float)) == 0;
}

}  // namespace

FrameQuality quality_of(Renderer& renderer, const Camera& camera, const RenderSettings& settings,
                        const Image& truth, ThreadPool& pool) {
  Image image = renderer.render(camera, settings).color;
  FrameQuality quality;
  quality.repeats = equal_bits(image, renderer.render(camera, settings).color);
  quality.psnr = psnr_8bit(image, truth);
  Image clamped_truth = truth;
  clamp_to_unit(image);
  clamp_to_unit(clamped_truth);
  quality.ssim = ssim(image, clamped_truth, pool);
  quality.flip = flip(clamped_truth, image, pool);
  return quality;
}

void set_quality(const FrameQuality& quality, BenchRow& row) {
  row.psnr_vs_reference = quality.psnr;
  row.ssim_vs_reference = quality.ssim;
  row.flip_vs_reference = quality.flip;
  row.repeats = quality.repeats;
}

}  // namespace qs
