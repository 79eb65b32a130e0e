// SPDX-License-Identifier: MIT
//
// SSIM and absolute differences of a caller's pictures on the GPU, with derivatives. Derivatives
// have the bits of the CPU; the sums of the means are in another, fixed order.
#pragma once

#include <cstddef>

#include "learn/diff/cuda/frame.h"
#include "learn/diff/strided_arrays.h"

namespace qs::cuda::diff {

/// Pictures of one size: batch x channels x height x width.
template <class T>
struct PictureBatch {
  Pixels<T> first;          ///< the first picture
  std::ptrdiff_t next = 0;  ///< elements from a picture of the batch to the next

  QS_HD T& at(int picture, int channel, int x, int y) const {
    return (&first.at(x, y, channel))[picture * next];
  }
};

struct BatchSizes {
  int pictures, channels, height, width;
  int margin;  ///< pixels nearer to the border do not count in SSIM

  std::size_t planes() const {
    return static_cast<std::size_t>(pictures) * static_cast<std::size_t>(channels);
  }
  /// The number of all values, and of the values whose SSIM counts.
  double values() const { return static_cast<double>(planes()) * height * width; }
  double counted() const {
    return static_cast<double>(planes()) * (height - 2 * margin) * (width - 2 * margin);
  }
};

struct ComparedPictures {
  BatchSizes sizes;
  PictureBatch<const float> a, b;
};

/// Bytes of the scratch memory of similarity().
std::size_t bytes_for_similarity(const BatchSizes& sizes);

/// At most INT32_MAX values. Enqueues the means: SSIM, and absolute differences unless `l1` is
/// null. `terms`: 3 fields of a number per value, for similarity_backward(); null: not wanted.
void similarity(const ComparedPictures& compared, const Queue& queue, void* scratch, float* ssim,
                float* l1, float* terms);

/// Enqueues the derivatives by the values of `a`, from those by the means. `by_l1` may be null.
void similarity_backward(const ComparedPictures& compared, const float* terms, const float* by_ssim,
                         const float* by_l1, const Queue& queue, const PictureBatch<float>& by_a);

}  // namespace qs::cuda::diff
