// SPDX-License-Identifier: MIT
//
// A small renderer in double precision whose rules can be changed one by one. It draws the image
// that another renderer would draw with a mistake. With the rules of 3DGS it draws the image of
// mode `reference`.
#pragma once

#include <limits>

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

}  // namespace qs
