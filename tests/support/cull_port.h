// SPDX-License-Identifier: MIT
//
// A port of five culling modes as a reader of the papers would write it, in double precision and
// without the kernels' headers, and the usual bugs of such ports.
#pragma once

#include <set>
#include <string>

#include "support/cull_vectors.h"

namespace qs::test {

enum class PortBug {
  none,
  half_pixel,        ///< pixel centres at i + 1/2 instead of i
  larger_radius,     ///< box from the larger eigenvalue, rounded up, on both axes
  three_sigma,       ///< the ellipse of 3 sigma: the opacity is ignored
  faint_kept,        ///< opacity below 1/255 is not dropped
  no_factor_two,     ///< gamma = ln(255 opacity)
  last_tile,         ///< the end of a run is floor(high / 16) instead of ceil
  partial_tile,      ///< a last tile that the picture cuts is left out
  truncated,         ///< int() instead of floor() for negative coordinates
  swapped_conic,     ///< a and c exchanged
  wrong_sign,        ///< the sign of b is inverted, which exchanges the major and minor quadrants
  no_root_of_f,      ///< the minor boxes scaled by f^2
  single_b,          ///< b x y instead of 2 b x y in the quadratic form
  corners_only,      ///< a tile is listed if one of its corners is inside the ellipse
  borders,           ///< the square of a tile's borders instead of its pixel centres
  columns_first,     ///< tile index = column * rows + row
  dilated_twice,     ///< 0.3 added to the variances again
  square_not_ceiled  ///< the radius of 3dgs not rounded up
};

/// The tiles that the port lists; `mode` is 3dgs, adr, dualbox, quadbox or exact.
std::set<int> tiles_of_port(const std::string& mode, const CullVector& vector,
                            PortBug bug = PortBug::none);

}  // namespace qs::test
