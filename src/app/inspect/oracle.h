// SPDX-License-Identifier: MIT
//
// The oracle: a backend's frame against the fp64 reference of the same view, or of a part of it,
// with the first pixel, tile and Gaussian at which they part named. What a frame should look like
// is the reference's business alone: no list, footprint or alpha of the frame is trusted.
#pragma once

#include <optional>
#include <string>

#include "raster/renderer.h"

namespace qs {

/// Why a pixel is not the reference's.
enum class Disagreement {
  missing,   ///< the frame lacks the Gaussian's contribution
  extra,     ///< the reference lacks it
  alpha,     ///< both have it, with different alphas
  color,     ///< both have it, with different colours
  stops,     ///< one of them stops at the Gaussian, the other blends it
  rounding,  ///< all contributions agree
};
inline constexpr const char* kDisagreements[] = {"lacks it",
                                                 "should not have it",
                                                 "gives it another alpha",
                                                 "gives it another color",
                                                 "stops at another one",
                                                 "differs by rounding only"};

struct Verdict {
  PixelBox region;
  double psnr = 0;                        ///< dB, of the region's 8-bit values
  int largest = 0;                        ///< difference of an 8-bit value
  std::uint64_t different_pixels = 0;     ///< beyond the tolerance
  std::optional<glm::ivec2> pixel;        ///< the first of them, row by row
  int tile = -1;                          ///< of that pixel
  std::optional<std::uint32_t> gaussian;  ///< the first of the pixel on which they disagree
  Disagreement why = Disagreement::rounding;
};

/// The reference's image of a region, 0 outside of it: takes seconds, so it reports and can be
/// cancelled. `cpu`: a CPU renderer with the scene.
Image reference_of(Renderer& cpu, const Camera& camera, RenderSettings settings,
                   std::optional<PixelBox> region, const Progress& progress);

/// `frame`: of `camera` and `settings`, with color and trace. `cpu`: a CPU renderer with the scene.
/// `tolerance`: what a difference of 8-bit values must exceed to be told. An empty region is the
/// whole image. Throws Cancelled.
Verdict ask_oracle(Renderer& cpu, const Camera& camera, RenderSettings settings, const Frame& frame,
                   std::optional<PixelBox> region, int tolerance, const Progress& progress);

/// The same with the reference's image at hand: `truth` is what mode reference draws of the region.
Verdict judge(Renderer& cpu, const Camera& camera, RenderSettings settings, const Frame& frame,
              const Image& truth, std::optional<PixelBox> region, int tolerance,
              const Progress& progress);

/// "equal to the reference within 1/255" or what parts them, for people.
std::string verdict_sentence(const Verdict& verdict, int tolerance);

}  // namespace qs
