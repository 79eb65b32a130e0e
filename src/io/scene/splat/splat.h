// SPDX-License-Identifier: MIT
//
// .splat (antimatter15): rows of 32 bytes without a header: position and linear scale as floats,
// colour and opacity as four bytes, the quaternion w, x, y, z as bytes (v - 128) / 128. The format
// has no magic number; files are recognised by values that are plausible only in such rows.
//
// .ksplat (GaussianSplats3D), version 0.1, compression levels 0 to 2. Layout: a header and section
// headers, then per section the lengths and centres of its buckets and one row per Gaussian. Each
// section's layout is computed from its header in 64 bits and checked against the file's size
// before anything is allocated.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>

#include "base/parallel.h"
#include "base/progress.h"
#include "io/bytes/byte_text.h"
#include "io/cloud/scene.h"
#include "raster/scene/gaussian_cloud.h"

namespace qs {

RecogniseScene recognises_splat, recognises_ksplat;
ReadScene read_splat, read_ksplat;

/// Writes the largest Gaussians first, as viewers that draw a file while downloading it expect.
/// View-dependent colour is lost; base colours are clamped to 0..1.
WriteScene write_splat;

}  // namespace qs
