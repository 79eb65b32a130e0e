// SPDX-License-Identifier: MIT
//
// The image quality of a renderer on one view: against the fp64 reference, and against itself.
#pragma once

#include "app/measure/bench_row.h"
#include "raster/api/renderer.h"

namespace qs {

/// Renders the view twice and sets the columns of `row` that compare the images: with `truth`, the
/// fp64 reference, and with each other. Throws what the renderer throws.
void judge_quality(Renderer& renderer, const Camera& camera, const RenderSettings& settings,
                   const Image& truth, ThreadPool& pool, BenchRow& row);

}  // namespace qs
