// SPDX-License-Identifier: MIT
//
// A photograph beside the model's picture of the same view, as plain data. The trainer gives the
// views; a thread reads the photographs, and the render thread draws the pictures
// (render/test_view.h).
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "raster/api/renderer.h"

namespace qs {

/// A photograph at the size of training.
struct TestPhotograph {
  Image image;
  std::vector<std::uint8_t> mask;  ///< per pixel, 0: does not count; empty: all count
};

/// The test views of a run; the training views if no view is held out.
struct TestViews {
  std::vector<Camera> cameras;  ///< of the size of training, with names; not empty
  bool held_out = true;         ///< the trainer does not train from them
  RenderSettings settings;      ///< as the trainer draws test views
  /// Reads a photograph on any thread. Throws Error(input).
  std::function<TestPhotograph(std::size_t view)> read;
};

/// The model's picture of a view, compared with the photograph as the trainer's evaluation does.
struct TestComparison {
  std::size_t view = 0;
  int iteration = 0;                     ///< of the model
  std::shared_ptr<const Image> picture;  ///< shown_in_panel()
  double psnr = 0, ssim = 0;             ///< of the size of training
};

/// The view that the panel shows. It stays from the photograph's reading to the next choice.
struct TestView {
  std::size_t view = 0;                              ///< index into TestViews::cameras
  bool asked = false;                                ///< the photograph is being read
  std::shared_ptr<const TestPhotograph> photograph;  ///< null until it is read
  std::shared_ptr<const Image> shown;                ///< shown_in_panel() the photograph
  std::string problem;                               ///< the reason why it cannot be read
  bool compares = false;                             ///< the render thread draws the picture
  double compared_at = -1e9;                         ///< Viewer::now of the last comparison
  TestComparison comparison;                         ///< without a picture: none of this view yet
};

/// The longest side of a picture in the panel, pixels.
inline constexpr int kTestPictureSide = 1024;

/// Seconds from a comparison to the next one of the same view while the model is trained.
inline constexpr double kTestViewSeconds = 2;

}  // namespace qs
