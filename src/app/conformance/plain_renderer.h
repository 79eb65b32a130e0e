// SPDX-License-Identifier: MIT
//
// A small renderer in double precision whose rules can be changed one by one. It draws the image
// that another renderer would draw with a mistake. With the rules of 3DGS it draws the image of
// mode `reference`.
#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "app/conformance/kit_scenes.h"
#include "raster/api/renderer.h"
#include "raster/kernel/constants.h"

namespace qs {

/// The rules that a change of the cloud, the camera or the settings cannot express. The default
/// values are the rules of 3DGS.
struct Rules {
  enum class Order { depth, depth_reversed, distance, file };
  enum class Stop { before, after, never };

  Order order = Order::depth;  ///< Gaussians are sorted by view z, front to back
  bool reversed_ties = false;  ///< true: at equal keys the last Gaussian of the file comes first
  Stop stop = Stop::before;    ///< the Gaussian that would pass the limit is not blended
  double alpha_min = fp64::kAlphaMin;
  double alpha_max = fp64::kAlphaMax;
  double transmittance_min = fp64::kTransmittanceMin;
  double falloff = 0.5;  ///< factor of the squared distance in standard deviations
  double cut_sigmas = std::numeric_limits<double>::infinity();  ///< nothing is drawn beyond
  double eigenvalue_floor = 0;   ///< px^4, under the root of the eigenvalues of the ellipse
  double slope_limit = 1;        ///< factor on the limit of the slopes in the Jacobian
  bool view_directions = false;  ///< SH are evaluated with directions in view axes
  bool clamps_dark = true;       ///< colours of Gaussians below 0 become 0
  bool clamps_bright = false;    ///< colours above 1 become 1
};

/// Tries every Gaussian at every pixel: for small images. Not clamped.
Image draw_plain(const GaussianCloud& cloud, const Camera& camera, const RenderSettings& settings,
                 const Rules& rules);

// The usual mistakes of renderers. Each can be applied to a drawing, so that the picture of a
// renderer can be compared with pictures that have the mistake.
// To add a mistake: a function and a row of kMistakes in mistakes.cpp. The tests run for every row:
// it must change a scene of the kit, and no other mistake may draw all scenes like it.
// The tests make the same mistakes in two other renderers, which the judge does not know: one that
// reads the kit's files (tests/support/planted_renderer.h) and the plugin of examples/plugin
// (tests/plugin/mistakes.h).

/// Everything that a mistake may change before and after a scene is drawn.
struct Drawing {
  KitView view;
  Rules rules;
  std::vector<Image (*)(const Image&)> afterwards = {};  ///< applied to the finished image
};

struct Mistake {
  const char* name;
  const char* what;       ///< one sentence without its full stop, about the renderer
  std::string_view part;  ///< two mistakes in the same part of the renderer exclude each other
  void (*make)(Drawing& drawing);
};

/// Several mistakes are made in this order.
std::span<const Mistake> mistakes();

/// Indices of mistakes(), ascending.
using MistakeSet = std::vector<std::size_t>;

/// The empty set; or each mistake alone; or every two mistakes that do not exclude each other.
std::vector<MistakeSet> sets_of_mistakes(int count);

/// "quaternion-xyzw + dilation-missing"; "none" for an empty set.
std::string names_of(const MistakeSet& set);

/// A view drawn with these mistakes. They change `rules`.
Image draw_with(const KitView& view, const MistakeSet& set, const Rules& rules = {});

/// RGB values as in a PNG file, row by row.
using Picture8 = std::vector<std::uint8_t>;
Picture8 picture8(const Image& image);

}  // namespace qs
