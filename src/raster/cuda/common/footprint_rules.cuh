// SPDX-License-Identifier: MIT
//
// The part of the settings that decides which footprint a Gaussian has.
#pragma once

#include "raster/api/renderer.h"
#include "raster/kernel/footprint.h"

namespace qs::cuda {

/// RenderSettings::antialiased may be unset, so it is passed.
inline FootprintRules footprint_rules(const RenderSettings& settings, bool antialiased) {
  return {row_of(settings.mode).keeps_faint, antialiased, settings.splat_scale,
          static_cast<float>(settings.dilation)};
}

}  // namespace qs::cuda
