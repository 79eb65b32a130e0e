// SPDX-License-Identifier: MIT
//
// Reads glTF 2.0 (.glb and .gltf) with KHR_gaussian_splatting (as ratified, with linear SCALE; the
// logarithms of its draft are detected) and KHR_gaussian_splatting_compression_spz_2. Reads all
// Gaussians of the default scene and applies the transforms of their nodes.
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

RecogniseScene recognises_gltf;
ReadScene read_gltf;

/// Writes binary glTF with KHR_gaussian_splatting as ratified: one mesh of points, all values
/// floats, linear scales, in glTF's frame. Lossless except for rounding when logarithms are
/// converted to values and back.
WriteScene write_glb;

}  // namespace qs
