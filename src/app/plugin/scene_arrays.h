// SPDX-License-Identifier: MIT
//
// A scene, a camera and its settings as plugins get them. The arrays of a QsScene are in one block
// of memory that this process shares with the plugin's, an anonymous file mapped in both, with the
// same layout.
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "base/descriptor.h"
#include "base/parallel.h"
#include "quadsplat/plugin.h"
#include "raster/api/renderer.h"
#include "raster/scene/gaussian_cloud.h"

namespace qs {

/// A mapping of a whole file.
class Mapping {
 public:
  Mapping() = default;
  /// Throws Error(device).
  Mapping(int descriptor, std::size_t bytes);

  std::size_t size() const { return data_ ? data_.get_deleter().bytes : 0; }
  std::byte* data() const { return data_.get(); }
  float* floats(std::size_t offset_bytes = 0) const {
    return reinterpret_cast<float*>(data() + offset_bytes);
  }

 private:
  struct Unmap {
    std::size_t bytes;
    void operator()(std::byte* data) const;
  };
  std::unique_ptr<std::byte, Unmap> data_;
};

/// The file with its mapping in this process.
class SharedMemory {
 public:
  /// Empty. Throws Error(device).
  SharedMemory();

  /// Makes the file `bytes` long and maps it; new bytes are 0. Throws Error(device).
  void resize(std::size_t bytes);

  int descriptor() const { return file_.get(); }
  const Mapping& mapping() const { return mapping_; }

 private:
  Descriptor file_;
  Mapping mapping_;
};

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
