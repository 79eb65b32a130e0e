// SPDX-License-Identifier: MIT
//
// The chart of the zoom recorder as a figure on white, for machines without gnuplot.
#pragma once

#include <filesystem>

#include "app/picture/figure.h"
#include "app/viewer/state/zoom_recorder.h"

namespace qs {

/// The chart of one quantity. `bundle` has rows.
Figure zoom_figure(const ZoomBundle& bundle, ZoomQuantity quantity);

/// Writes the figures of all quantities to the folder, as .png and .svg with the names of the
/// plots. Throws Error(input).
void write_zoom_figures(const ZoomBundle& bundle, const std::filesystem::path& folder);

}  // namespace qs
