// SPDX-License-Identifier: MIT
//
// Compares several variants of one view with the truth, which is the reference or one of the
// variants, and finds the crop where they differ most. A variant is one way to render a view: a
// culling mode on a pipeline of a backend. Draws the comparison as papers print it: a column per
// variant with the crop, its amplified difference from the truth, and its numbers. Also formats it
// as a table.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/parallel.h"
#include "raster/api/renderer.h"

namespace qs {

struct Variant {
  CullMode mode =
      default_mode();  ///< kReferenceMode runs on the CPU; the other members are ignored
  Pipeline pipeline = kDefaultPipeline;
  Backend backend = Backend::cpu;

  bool operator==(const Variant&) const = default;
};

/// "cuda fast", "cuda classic" or "cpu".
std::string drawn_by(const Variant& variant);

/// "quadbox, cuda fast", "quadbox, cpu" or "reference".
std::string full_name(const Variant& variant);

/// The shortest name that distinguishes `variant` from `other`: "quadbox" or "quadbox, cuda
/// classic".
std::string name_beside(const Variant& variant, const Variant& other);

/// The variant with this full_name(); or with this mode, and backend and pipeline of `like`. Unset
/// if the name is unknown or the backend is not available.
std::optional<Variant> find_variant(std::string_view name, const Variant& like);

struct ViewVariant {
  std::string name;    ///< "quadbox" or "quadbox, cuda fast"
  Image color;         ///< picture of the whole view
  RenderStats stats;   ///< including used_pairs
  double psnr = 0;     ///< dB against the truth
  int largest = 0;     ///< largest difference of an 8-bit value from the truth
  std::string remark;  ///< check_sentence(); may be empty
};

struct ViewComparison {
  std::string truth_name;
  Image truth;
  std::vector<ViewVariant> variants;
  PixelBox crop;
};

/// Renders the view and compares it with `truth`. `remark` stays empty.
ViewVariant draw_variant(Renderer& renderer, const Camera& camera, const RenderSettings& settings,
                         std::string name, const Image& truth, std::stop_token stop = {});

/// The box of this size, limited to the image's, in which a variant differs most from the truth, by
/// the sum of squared differences. The middle of the image if no variant differs.
PixelBox most_different_crop(const Image& truth, const std::vector<ViewVariant>& variants,
                             glm::ivec2 size);

/// A fifth of the image's width and height, at least 16 pixels.
glm::ivec2 default_crop_size(int width, int height);

/// `where`: scene and view for the headline. `pool` scales the images.
Image draw_comparison(const ViewComparison& comparison, int amplification, const std::string& where,
                      ThreadPool& pool);

/// A table with a line per variant: PSNR, largest difference, pairs, false positives.
std::string format_comparison(const ViewComparison& comparison);

}  // namespace qs
