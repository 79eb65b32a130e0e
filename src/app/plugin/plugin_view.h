// SPDX-License-Identifier: MIT
//
// A frame's camera and settings as plugins get them.
#pragma once

#include "quadsplat/plugin.h"
#include "raster/api/renderer.h"

namespace qs {

/// `sh_degree` and `antialiased`: of the cloud.
QsView view_of(const Camera& camera, const RenderSettings& settings, int sh_degree,
               bool antialiased);

}  // namespace qs
