// SPDX-License-Identifier: MIT
//
// A scene, a camera and its settings as plugins get them. The arrays of a QsScene are in one block
// of memory with the same layout in both processes.
#pragma once

#include <cstddef>
#include <vector>

#include "app/plugin/shared_memory.h"
#include "base/parallel.h"
#include "quadsplat/plugin.h"
#include "raster/api/renderer.h"
#include "raster/scene/gaussian_cloud.h"

namespace qs {

/// One array: a member of QsScene and its number of values per Gaussian.
struct SceneArray {
  const float* QsScene::*member;
  std::size_t width;
  std::size_t offset_bytes;  ///< its place in the memory of all arrays
};

/// The arrays of a scene in the order of QsScene; uses its `count` and `sh_degree`.
std::vector<SceneArray> scene_arrays(const QsScene& scene);

/// Bytes of the memory of all arrays.
std::size_t scene_bytes(const QsScene& scene);

/// Points the members of `scene` into memory that fill_scene() filled.
void point_into(const Mapping& memory, QsScene& scene);

/// Resizes `memory` and writes the arrays of a cloud to it. Returns the scene without pointers.
/// Throws Error(device).
QsScene fill_scene(const GaussianCloud& cloud, ThreadPool& pool, SharedMemory& memory);

/// `sh_degree` and `antialiased`: of the cloud.
QsView view_of(const Camera& camera, const RenderSettings& settings, int sh_degree,
               bool antialiased);

}  // namespace qs
