// SPDX-License-Identifier: MIT
//
// Memory for large clouds. With huge pages the kernel hands out the 236 MB of a million Gaussians
// in 2 MiB pages; faulting them in as 4 KiB pages takes about as long as reading the file.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "raster/scene/gaussian_cloud.h"

namespace qs {

/// Advises the kernel to use huge pages for memory that was not touched yet. Nothing depends on it.
void prefer_huge_pages(void* memory, std::size_t bytes);

/// Bytes of memory that the system can give without swapping; 2^64 - 1 if it does not say.
std::uint64_t available_memory();

/// A cloud of `count` uninitialised Gaussians. The caller has checked `count` against the file's
/// size.
GaussianCloud make_cloud(std::size_t count, int sh_degree);

/// SH coefficients of a Gaussian, and the first coefficient of Gaussian `i`.
inline std::size_t sh_count(const GaussianCloud& cloud) {
  return static_cast<std::size_t>(sh_coefficient_count(cloud.sh_degree));
}
inline glm::vec3* sh_of(GaussianCloud& cloud, std::size_t i) {
  return &cloud.sh[i * sh_count(cloud)];
}
inline const glm::vec3* sh_of(const GaussianCloud& cloud, std::size_t i) {
  return &cloud.sh[i * sh_count(cloud)];
}

/// Copies Gaussian `i` of `from` to place `k` of `to`, with the SH coefficients that both have.
inline void copy_gaussian(const GaussianCloud& from, std::size_t i, GaussianCloud& to,
                          std::size_t k) {
  to.positions[k] = from.positions[i];
  to.log_scales[k] = from.log_scales[i];
  to.rotations[k] = from.rotations[i];
  to.opacity_logits[k] = from.opacity_logits[i];
  std::copy_n(sh_of(from, i), std::min(sh_count(from), sh_count(to)), sh_of(to, k));
}

// Reduces the SH degree: less memory and faster rendering, with less view dependence.

/// The cloud with SH up to `degree` (0..3); unchanged if its degree is not higher.
GaussianCloud with_sh_degree(GaussianCloud cloud, int degree);

}  // namespace qs
