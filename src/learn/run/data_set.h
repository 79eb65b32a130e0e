// SPDX-License-Identifier: MIT
//
// A data set to train from: photographs with their cameras, divided into training and test views,
// and the points of structure from motion.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <glm/vec3.hpp>

#include "base/parallel.h"
#include "base/progress.h"
#include "io/camera/cameras.h"
#include "io/camera/lens.h"
#include "learn/step/photograph.h"
#include "raster/scene/camera.h"
#include "raster/scene/image.h"

namespace qs::train {

// A photograph to train from or to test with: its camera and its pixels, at the size of training.

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
/// photograph's size. Its black and its transparent pixels are masked out, and so is every pixel of
/// the view that contains a part of one.
PhotographView read_view(const PhotographSource& source, ThreadPool& pool);

/// Half of the machine's memory, in bytes.
std::uint64_t half_of_memory();

struct DataOptions {
  std::filesystem::path data;
  /// in `data`; empty: as transforms.json names photographs, else `images`, or `data` itself
  std::filesystem::path images;
  /// in `data`; empty: the masks that transforms.json names, else `masks` if that folder exists
  std::filesystem::path masks;
  std::optional<int> resolution_scale;  ///< unset: 1, but photographs at most 1,600 pixels wide
  int holdout = 8;          ///< every N-th view with a photograph, by name, is a test view; 0: none
  glm::vec3 background{0};  ///< behind transparent photographs
  bool keep_alpha = false;  ///< photographs are blended when they are compared
  std::uint64_t photo_memory = half_of_memory();  ///< bytes for photographs
};

struct DataSet {
  std::filesystem::path folder, photographs;
  std::vector<PhotographView> training, test;  ///< both are sorted by name
  std::vector<ScenePoint> points;              ///< empty if the data set has none
  std::string used;                   ///< cameras, photographs and masks: a part of a sentence
  std::string left_out;               ///< and why: a part of a sentence, or ""
  std::vector<std::string> warnings;  ///< sentences
  std::filesystem::path points_file;  ///< empty: none
  std::size_t repeated_points = 0;    ///< in points_file; `points` has each place once
  bool blender = false;               ///< has transforms_train.json
  std::uint64_t photo_memory = 0;     ///< bytes that photograph_cache.h may use
  /// The place in the world from which cameras and points count, see GaussianCloud::origin
  glm::dvec3 origin{0};
  bool published_extent = false;  ///< extent() includes cameras far away from all others

  /// True if the photographs need more than photo_memory, so that all views are without pixels.
  bool on_disk() const { return !training.empty() && !training.front().has_pixels(); }

  void release_pixels();  ///< releases the pixels of all views

  std::vector<LensCamera> cameras() const;  ///< the cameras of all views, sorted by name

  /// 1.1 times the largest distance of a training camera from their mean; without outliers() unless
  /// published_extent.
  double extent() const;
  std::vector<Camera> training_cameras() const;

  /// Numbers of views and a hash of cameras and photographs, to recognise the same data again.
  std::string fingerprint() const;
};

/// Blender's data sets have transforms_train.json and transforms_test.json; their views are the
/// training and the test views, and names begin with the photographs' folder: "train/r_0".
/// Photographs and masks are found by find_pictures(). The mask of the photograph a/1.jpg in a
/// folder of masks is a/1.jpg.png or a/1.png. If all pixels together exceed
/// DataOptions::photo_memory, no view has its pixels. Throws Error(input) naming the file, and
/// Cancelled.
DataSet read_data_set(const DataOptions& options, ThreadPool& pool, const Progress& progress = {});

/// 1.1 times the largest distance of a camera from their mean; 1 if all are in one place.
double extent_of(const std::vector<Camera>& cameras);

}  // namespace qs::train
