// SPDX-License-Identifier: MIT
//
// A photograph to train from or to test with: its camera and its pixels, at the size of training.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

#include <glm/vec3.hpp>

#include "base/parallel.h"
#include "io/camera/lens.h"
#include "learn/step/photograph.h"
#include "raster/scene/camera.h"
#include "raster/scene/image.h"

namespace qs::train {

/// The file of a photograph and the options of reading it.
struct PhotographSource {
  LensCamera taken;                     ///< the camera at the photograph's full size
  std::filesystem::path file, mask;     ///< `mask` empty: every pixel counts
  std::optional<int> resolution_scale;  ///< unset: 1, but photographs at most 1,600 pixels wide
  glm::vec3 background{0};              ///< behind transparent photographs
  bool keep_alpha = false;              ///< photographs are blended when they are compared
};

struct PhotographView {
  Camera camera;             ///< the undistorted camera at the size of training
  std::optional<Lens> lens;  ///< the lens that took the photograph, scaled to this size
  PhotographSource source;
  std::vector<std::uint8_t> rgb;    ///< row by row, over the background of the source
  std::vector<std::uint8_t> alpha;  ///< per pixel; empty: opaque, or keep_alpha is off
  std::vector<std::uint8_t> mask;   ///< per pixel, 0: masked out, else 1; empty: all count

  Photograph photograph() const { return {rgb, alpha, mask}; }
  Image image() const;

  /// Pixels may have been released to save memory; photograph_cache.h reads them again.
  bool has_pixels() const { return !rgb.empty(); }
  void release_pixels();
  /// The hash of the pixels; known also while they are released.
  std::uint64_t content_hash() const;
  std::uint64_t bytes() const;

  std::uint64_t released_hash = 0, released_bytes = 0;  ///< set by release_pixels()
};

/// Throws Error(input) naming the file of the photograph or of the mask. A mask has the
/// photograph's size. Its black pixels are masked out, and so is every pixel of the view that
/// contains a part of a black pixel.
PhotographView read_view(const PhotographSource& source, ThreadPool& pool);

}  // namespace qs::train
