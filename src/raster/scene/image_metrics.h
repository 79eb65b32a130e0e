// SPDX-License-Identifier: MIT
//
// Image quality metrics as papers define them: PSNR and SSIM (Wang et al. 2004), and the resampling
// that gives two images the same size first. Values are floats with a peak of 1 and all channels
// weigh the same. Both images have the same width, height and channels. Sums are in double
// precision and do not depend on the number of threads. PSNR and SSIM take an optional mask, one
// value per pixel: pixels of value 0 are left out of the means, and count as 0 in both images where
// a window reaches them, like the pixels outside of the image.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "base/parallel.h"
#include "raster/kernel/ssim.h"
#include "raster/scene/image.h"

namespace qs {

/// Peak signal-to-noise ratio in dB for values up to `peak`; +infinity for an error of 0.
double psnr_of(double mean_squared_error, double peak = 1);

/// psnr_of() the mean squared error of all values. `mask` is empty or has one value per pixel.
double psnr(const Image& a, const Image& b, ThreadPool& pool,
            std::span<const std::uint8_t> mask = {});

/// The sums of the squared differences in blocks of `side` x `side` pixels, row by row. The blocks
/// at the right and lower borders may be smaller.
std::vector<double> block_errors(const Image& a, const Image& b, int side = 64);

/// The least psnr_of() of the block_errors().
double worst_block_psnr(const Image& a, const Image& b, int side = 64);

/// The weights of the window along one axis, sigma 1.5. Their sum is 1.
std::array<double, kSsimSize> ssim_window();

enum class SsimBorder {
  zeros,  ///< every pixel counts; values outside of the image are 0
  crop,   ///< only pixels whose window lies inside of the image count, as in torchmetrics
};

/// Mean over pixels and channels of the structural similarity in a Gaussian window of 11 x 11
/// pixels with sigma 1.5, K = 0.01 and 0.03. 1 if equal. With SsimBorder::crop both sides are at
/// least 11 pixels long.
double ssim(const Image& a, const Image& b, ThreadPool& pool, SsimBorder border = SsimBorder::zeros,
            std::span<const std::uint8_t> mask = {});

/// The image at another size: every new pixel is the mean of the old pixels that it covers,
/// weighted by the covered area. Width and height are at least 1.
Image area_average(const Image& image, int width, int height, ThreadPool& pool);

/// Clamps values to 0..1; NaN becomes 0.
void clamp_to_unit(Image& image);

/// The linear value of an sRGB value; both are 0..1.
double linear_of_srgb(double v);

/// CIELab's f(t): the cube root, and a line near 0.
double lab_root(double t);

// FLIP, the difference that a viewer sees when two pictures alternate (Andersson et al. 2020,
// "FLIP: A Difference Evaluator for Alternating Images"), in its form for pictures of a display
// (LDR).

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
