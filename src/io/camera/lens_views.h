// SPDX-License-Identifier: MIT
//
// The lenses through which frames are drawn (raster/lens/lens_view.h).
#pragma once

#include <string>

#include "io/camera/lens.h"
#include "raster/lens/lens_view.h"

namespace qs {

/// A panorama (equirectangular) of 360 or 180 degrees across, and 180 from top to bottom.
LensView panorama_view(double degrees);

/// An equidistant fisheye of up to 360 degrees across the shorter side of the picture. It shows
/// nothing outside of this circle.
LensView fisheye_view(double degrees);

/// Parallel rays: the picture is `height` world units high.
LensView parallel_view(double height);

/// The lens of a photograph, or as a camera's would take it in another resolution. parse_lens()
/// reads its text.
LensView photograph_view(const Lens& lens);

/// A lens as words of the command line: MODEL,WIDTH,HEIGHT,PARAMETERS, with the values of a line of
/// COLMAP's cameras.txt. Throws Error(input) "WHERE: ...".
Lens parse_lens(const std::string& text, const std::string& where);

}  // namespace qs
