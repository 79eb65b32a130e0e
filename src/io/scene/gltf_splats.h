// SPDX-License-Identifier: MIT
//
// The Gaussians of one glTF primitive, from its accessors or unpacked, and their way into a cloud.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "io/scene/gltf_file.h"
#include "raster/scene/gaussian_cloud.h"

namespace qs {

/// The Gaussians of one primitive, in glTF's frame (LUF).
struct GltfSplats {
  std::uint64_t count = 0;
  int degree = 0;
  std::shared_ptr<const GaussianCloud> cloud;  ///< of the compressed ones; the others have numbers
  GltfNumbers positions, rotations, scales, opacities;
  std::vector<GltfNumbers> sh;
  bool scales_are_logarithms = false;
};

/// What was wrong with single values, counted while the cloud is filled.
struct GltfClamped {
  std::atomic<std::size_t> scales = 0, opacities = 0;
};

/// Gaussian `from` of the primitive becomes `to` of the cloud, whose degree is at least as high.
/// May be called from several threads.
void fill_gaussian(const GltfSplats& splats, std::uint64_t from, GaussianCloud& cloud,
                   std::size_t to, GltfClamped& clamped);

/// Whether these are the draft's logarithms instead of linear scales.
bool are_logarithms(const GltfNumbers& scales);

}  // namespace qs
