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

#include "io/camera/lens.h"
#include "io/camera/points.h"
#include "raster/base/parallel.h"
#include "raster/base/progress.h"
#include "raster/scene/camera.h"
#include "raster/scene/image.h"

namespace qs::train {

struct DataOptions {
  std::filesystem::path data;
  std::filesystem::path images;         ///< in `data`; empty: `images`, or `data` without one
  std::optional<int> resolution_scale;  ///< unset: 1, but photographs at most 1,600 pixels wide
  int holdout = 8;          ///< every N-th view with a photograph, by name, is a test view; 0: none
  glm::vec3 background{0};  ///< behind transparent photographs
  bool keep_alpha = false;  ///< photographs are blended by target()
};

struct PhotographView {
  Camera camera;             ///< of the size of training, undistorted
  std::optional<Lens> lens;  ///< of the photograph as it was taken, in this size
  std::filesystem::path file;
  std::vector<std::uint8_t> rgb;    ///< row by row, over the background of DataOptions
  std::vector<std::uint8_t> alpha;  ///< per pixel; empty: opaque, or DataOptions::keep_alpha is off

  /// Per pixel, 0..1. With alpha, `rgb` is over black and `background` is added.
  std::vector<glm::vec3> target(glm::vec3 background) const;
  Image image() const;
};

struct DataSet {
  std::filesystem::path folder, photographs;
  std::vector<PhotographView> training, test;  ///< by name
  std::vector<ScenePoint> points;              ///< empty if the data set has none
  std::size_t skipped = 0;                     ///< cameras without a photograph
  bool blender = false;                        ///< has transforms_train.json

  std::vector<LensCamera> cameras() const;  ///< of all views, by name

  /// 1.1 times the largest distance of a training camera from their mean.
  double extent() const;

  /// Numbers of views and a hash of cameras and photographs, to recognise the same data again.
  std::string fingerprint() const;
};

/// Blender's data sets have transforms_train.json and transforms_test.json; then these are the
/// training and the test views, and names begin with the photographs' folder: "train/r_0". Throws
/// Error(input) naming the file, and Cancelled.
DataSet read_data_set(const DataOptions& options, ThreadPool& pool, const Progress& progress = {});

/// 1.1 times the largest distance of a camera from their mean; 1 if all are in one place.
double extent_of(const std::vector<Camera>& cameras);

}  // namespace qs::train
