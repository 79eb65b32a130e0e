// SPDX-License-Identifier: MIT
//
// The plots of a zoom: FPS, milliseconds and pairs against the zoom, one curve per mode. Times have
// a band of 5-95 % of the frames.
#pragma once

#include <vector>

#include "app/report/plot.h"
#include "app/report/zoom_bundle.h"

namespace qs {

std::vector<Plot> zoom_plots(const ZoomBundle& bundle);

}  // namespace qs
