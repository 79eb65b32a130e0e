// SPDX-License-Identifier: MIT
//
// The Gaussians of one glTF primitive, from its accessors or from compressed data, and their
// conversion into a cloud.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "io/scene/gltf/gltf_file.h"
#include "raster/scene/gaussian_cloud.h"

namespace qs {

/// The Gaussians of one primitive, in glTF's frame (LUF).
struct GltfSplats {
  std::uint64_t count = 0;
  int degree = 0;
  std::shared_ptr<const GaussianCloud>
      cloud;  ///< set for compressed data; then the accessors below are empty
  GltfNumbers positions, rotations, scales;
  GltfNumbers opacities, colors;  ///< opacities, or RGBA as in drafts, 0 to 1
  std::vector<GltfNumbers> sh;    ///< begins with degree 0, or with degree 1 if there are `colors`
  bool scales_are_logarithms = false;
};

/// Counts of values out of range, gathered while the cloud is filled.
struct GltfClamped {
  std::atomic<std::size_t> scales = 0, opacities = 0;
};

/// Writes Gaussian `from` of the primitive to position `to` of the cloud, whose degree is at least
/// as high. May be called from several threads.
void fill_gaussian(const GltfSplats& splats, std::uint64_t from, GaussianCloud& cloud,
                   std::size_t to, GltfClamped& clamped);

/// True if these scales are logarithms, as in the extension's draft, instead of linear.
bool are_logarithms(const GltfNumbers& scales);

}  // namespace qs
