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

void judge_quality(Renderer& renderer, const Camera& camera, const RenderSettings& settings,
                   const Image& truth, ThreadPool& pool, BenchRow& row) {
  Image image = renderer.render(camera, settings).color;
  row.repeats = equal_bits(image, renderer.render(camera, settings).color);
  row.psnr_vs_reference = psnr_8bit(image, truth);
  Image clamped_truth = truth;
  clamp_to_unit(image);
  clamp_to_unit(clamped_truth);
  row.ssim_vs_reference = ssim(image, clamped_truth, pool);
  row.flip_vs_reference = flip(clamped_truth, image, pool);
}

}  // namespace qs
