// SPDX-License-Identifier: MIT
//
// How close two pictures are, as papers measure it: PSNR, SSIM (Wang et al. 2004), and the
// averaging that brings a picture to another's size first. Values are floats with a peak of 1; all
// channels count alike, so both pictures have the same width, height and channels.
// Sums are in double precision, and results do not depend on the number of threads.
#pragma once

#include "raster/base/parallel.h"
#include "raster/scene/image.h"

namespace qs {

/// Peak signal-to-noise ratio in dB for values up to `peak`; +infinity for an error of 0.
double psnr_of(double mean_squared_error, double peak = 1);

/// psnr_of() the mean squared error of all values.
double psnr(const Image& a, const Image& b, ThreadPool& pool);

/// Mean over pixels and channels of the structural similarity in a Gaussian window of 11 x 11
/// pixels with sigma 1.5, zeros outside of the picture, K = 0.01 and 0.03. 1 when equal.
double ssim(const Image& a, const Image& b, ThreadPool& pool);

/// The picture at another size: every new pixel is the mean of the area that it covers, parts of
/// pixels counted by their area. Width and height at least 1.
Image area_average(const Image& image, int width, int height, ThreadPool& pool);

/// Values outside 0..1 become 0 or 1, NaN becomes 0.
void clamp_to_unit(Image& image);

}  // namespace qs
