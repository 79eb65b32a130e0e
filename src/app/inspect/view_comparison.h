// SPDX-License-Identifier: MIT
//
// One view drawn in several ways (modes, pipelines, backends), judged by one of them or by the
// reference, and the part of it where they differ most.
#pragma once

#include <string>
#include <vector>

#include "raster/renderer.h"

namespace qs {

struct ViewVariant {
  std::string name;    ///< "quadbox", "quadbox, cuda fast"
  Image color;         ///< of the whole view
  RenderStats stats;   ///< with used_pairs
  double psnr = 0;     ///< dB against the truth
  int largest = 0;     ///< difference of an 8-bit value from the truth
  std::string remark;  ///< of the oracle; may be empty
};

struct ViewComparison {
  std::string truth_name;
  Image truth;
  std::vector<ViewVariant> variants;
  PixelBox crop;
};

/// Draws and counts; psnr and largest follow from `truth`.
ViewVariant draw_variant(Renderer& renderer, const Camera& camera, const RenderSettings& settings,
                         std::string name, const Image& truth, std::stop_token stop = {});

/// The box of this size in which the variants differ most from the truth (largest sum of squared
/// differences of any one of them); the middle of the image where none differs. The size is cut to
/// the image's.
PixelBox most_different_crop(const Image& truth, const std::vector<ViewVariant>& variants,
                             glm::ivec2 size);

/// A fifth of the image, in its shape.
glm::ivec2 default_crop_size(int width, int height);

/// |a - truth| of the 8-bit values inside the box, times `amplification`; 1 is white.
Image amplified_difference(const Image& a, const Image& truth, const PixelBox& box,
                           int amplification);

Image cropped(const Image& image, const PixelBox& box);

}  // namespace qs
