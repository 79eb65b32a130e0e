// SPDX-License-Identifier: MIT
//
// The sums of PSNR and SSIM of two pictures on the GPU, by the definitions of
// raster/scene/image_metrics.h and as there in double precision, in another, fixed order.
#pragma once

#include <cstddef>
#include <cstdint>

#include "learn/diff/cuda/frame.h"
#include "raster/scene/image_metrics.h"

namespace qs::cuda::diff {

/// A caller's picture of height x width x 3 values. Elements of 1 byte are 8-bit values, of 4 or 8
/// bytes real numbers.
struct GivenPicture {
  const void* data;
  std::ptrdiff_t down, right, deep;  ///< elements from a row, pixel or channel to the next
  int element_bytes;
};

struct GivenPictures {
  GivenPicture a, b, mask;  ///< mask: bytes, deep is 0; no data: every pixel counts
  int width, height;
  int margin;  ///< pixels nearer to the border do not count in SSIM
};

/// Sums over the values of pixels that count.
struct ComparisonSums {
  double squared;  ///< squared differences
  double ssim;
  std::uint64_t squared_8bit;  ///< squared differences of the values rounded to 8 bits
  std::uint64_t values;
  std::uint64_t values_inside;  ///< of SSIM

  // The metrics of image_metrics.h.
  double psnr() const { return psnr_of(squared / static_cast<double>(values)); }
  double psnr_8bit() const {
    return psnr_of(static_cast<double>(squared_8bit) / static_cast<double>(values), 255);
  }
  double mean_ssim() const { return ssim / static_cast<double>(values_inside); }
};

/// Bytes of the scratch memory of compare().
std::size_t bytes_to_compare(const GivenPictures& pictures);

/// Waits. Throws Error(device) and Cancelled.
ComparisonSums compare(const GivenPictures& pictures, bool with_ssim, const Queue& queue,
                       void* scratch);

}  // namespace qs::cuda::diff
