// SPDX-License-Identifier: MIT
//
// FLIP, the difference that a viewer sees when two pictures alternate (Andersson et al. 2020,
// "FLIP: A Difference Evaluator for Alternating Images"), in its form for pictures of a display
// (LDR).
#pragma once

#include "base/parallel.h"
#include "raster/scene/image.h"

namespace qs {

/// Pixels per degree of the visual field, at a screen 0.7 m wide and 0.7 m away with 3,840 pixels
/// across: the paper's default.
inline constexpr double kFlipPixelsPerDegree = 67.02064327658226;

/// The visible difference of every pixel, 0 to 1, one channel. Both images have the same size and
/// at least three channels: sRGB, clamped to 0..1. The result does not depend on the number of
/// threads.
Image flip_map(const Image& reference, const Image& test, ThreadPool& pool,
               double pixels_per_degree = kFlipPixelsPerDegree);

/// The mean of a map, in double precision.
double mean_flip(const Image& map);

/// The mean of flip_map(). 0 if the images are equal.
double flip(const Image& reference, const Image& test, ThreadPool& pool,
            double pixels_per_degree = kFlipPixelsPerDegree);

}  // namespace qs
