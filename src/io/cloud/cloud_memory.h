// SPDX-License-Identifier: MIT
//
// Memory for large clouds. With huge pages the kernel hands out the 236 MB of a million Gaussians
// in 2 MiB pages; faulting them in as 4 KiB pages takes about as long as reading the file.
#pragma once

#include <cstddef>

#include "raster/scene/gaussian_cloud.h"

namespace qs {

/// Advises the kernel to use huge pages for memory that was not touched yet. Nothing depends on it.
void prefer_huge_pages(void* memory, std::size_t bytes);

/// A cloud of `count` uninitialised Gaussians. The caller has checked `count` against the file's
/// size.
GaussianCloud make_cloud(std::size_t count, int sh_degree);

}  // namespace qs
