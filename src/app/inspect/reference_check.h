// SPDX-License-Identifier: MIT
//
// Compares a backend's frame with the fp64 reference and reports the first pixel, tile and Gaussian
// where they differ. Only the reference's own data is taken as correct: no list, footprint or alpha
// of the frame is trusted.
#pragma once

#include <optional>
#include <string>

#include "app/picture/image_difference.h"

namespace qs {

/// The reason why a pixel differs from the reference's.
enum class Disagreement {
  missing,   ///< only the reference blends the Gaussian
  extra,     ///< only the frame blends the Gaussian
  alpha,     ///< both blend it, with different alphas
  color,     ///< both blend it, with different colours
  stops,     ///< either the frame or the reference stops at the Gaussian, the other blends it
  rounding,  ///< all contributions agree
};

struct ReferenceCheck {
  PixelBox region;
  ImageDifference difference;  ///< inside the region
  int tile = -1;               ///< tile of difference.first
  /// the first Gaussian of that pixel on which frame and reference disagree
  std::optional<std::uint32_t> gaussian;
  Disagreement why = Disagreement::rounding;
};

/// A view, or the part of it that is compared.
struct CheckedView {
  const Camera& camera;
  const RenderSettings& settings;
  std::optional<PixelBox> region = {};  ///< unset = the whole image

  PixelBox pixels() const { return region.value_or(PixelBox{0, 0, camera.width, camera.height}); }
};

/// Renders the reference's image of a view, 0 outside of the region. Takes seconds: reports
/// progress and throws Cancelled. `cpu`: a CPU renderer with the scene.
Image render_reference(Renderer& cpu, const CheckedView& view, const Progress& progress);

/// Compares `frame`, which was rendered with color and trace for the view, with `reference`, the
/// result of render_reference() for the same view. Differences of 8-bit values up to `tolerance` do
/// not count. Throws Cancelled.
ReferenceCheck check_against_reference(Renderer& cpu, const CheckedView& view, const Frame& frame,
                                       const Image& reference, int tolerance,
                                       const Progress& progress);

/// The disagreement as a predicate whose subject is the frame: "does not blend it".
const char* disagreement_text(Disagreement why);

/// "equal to the reference within 1/255, 92.10 dB", or a description of the difference.
std::string check_sentence(const ReferenceCheck& check, int tolerance);

}  // namespace qs
