// SPDX-License-Identifier: MIT
//
// Memory for big clouds. With huge pages the kernel hands out the 236 MB of a million Gaussians in
// 2 MiB pieces; with 4 KiB pages the faults take about as long as reading the file.
#pragma once

#include <cstddef>

#include "raster/scene/gaussian_cloud.h"

namespace qs {

/// Asks for huge pages for memory that was not touched yet. Advice: nothing depends on it.
void prefer_huge_pages(void* memory, std::size_t bytes);

/// A cloud of `count` uninitialised Gaussians. The caller has checked `count` against real bytes.
GaussianCloud make_cloud(std::size_t count, int sh_degree);

}  // namespace qs
