// SPDX-License-Identifier: MIT
//
// Compares Frame::mode_pairs with the statistics of each mode's own frame.
#pragma once

#include <ostream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "raster/api/renderer.h"
#include "support/scenes.h"

namespace qs {

/// For messages of GoogleTest.
inline void PrintTo(const ModePairs& pairs, std::ostream* out) {
  *out << pairs.tile_pairs << " pairs of " << pairs.visible << " Gaussians";
}

namespace test {

/// Outputs that only count.
inline Outputs only_mode_pairs() {
  Outputs outputs;
  outputs.color = false;
  outputs.mode_pairs = true;
  return outputs;
}

/// The statistics of a frame in every mode; index = mode - 1.
inline std::vector<ModePairs> own_statistics(Renderer& renderer, const Camera& camera,
                                             RenderSettings settings) {
  Outputs statistics;
  statistics.color = false;
  std::vector<ModePairs> own;
  for (settings.mode = 1; settings.mode <= culler_count(); ++settings.mode) {
    const RenderStats& stats = renderer.render(camera, settings, statistics).stats;
    own.push_back({stats.tile_pairs, stats.visible});
  }
  return own;
}

/// The counts of `counting` must be the statistics of the frames of `drawing`.
inline void expect_own_statistics(Renderer& counting, Renderer& drawing, const Camera& camera,
                                  const RenderSettings& settings) {
  const std::vector<ModePairs> counted =
      counting.render(camera, settings, only_mode_pairs()).mode_pairs;
  const std::vector<ModePairs> own = own_statistics(drawing, camera, settings);
  ASSERT_EQ(counted.size(), own.size());
  for (std::size_t i = 0; i < own.size(); ++i) {
    SCOPED_TRACE(mode_name(static_cast<CullMode>(i) + 1));
    EXPECT_EQ(counted[i].tile_pairs, own[i].tile_pairs);
    EXPECT_EQ(counted[i].visible, own[i].visible);
  }
}

/// A scene and a view of it that are hard to count.
struct CountedScene {
  std::string name;
  GaussianCloud cloud;
  Camera camera;
  RenderSettings settings = {};
};

inline std::vector<CountedScene> counted_scenes(std::size_t gaussians) {
  const GaussianCloud cloud = random_cloud(gaussians, 0, 42);
  std::vector<CountedScene> scenes;
  for (const auto& [width, height] : {std::pair{1, 1}, {17, 33}, {16, 16}, {45, 161}, {320, 200}}) {
    const std::string name = "random " + std::to_string(width) + "x" + std::to_string(height);
    scenes.push_back({name, cloud, front_camera(width, height)});
  }
  scenes.push_back({"on all sides", surrounding_cloud(gaussians, 0, 7), front_camera(161, 117)});
  GaussianCloud empty;
  empty.resize(0, 0);
  scenes.push_back({"no Gaussian", empty, front_camera(64, 48)});
  scenes.push_back({"one", single_gaussian({0, 0, 3}, 0.1f, {1, 1, 1}, 2), front_camera(64, 48)});
  scenes.push_back({"behind", single_gaussian({0, 0, -3}, 1, {1, 1, 1}, 2), front_camera(64, 48)});
  scenes.push_back({"faint", single_gaussian({0, 0, 3}, 1, {1, 1, 1}, -9), front_camera(64, 48)});
  GaussianCloud huge = single_gaussian({0, 0, 3}, 1000, {1, 1, 1}, 0);
  append(huge, single_gaussian({5, 5, 3}, 2, {1, 1, 1}, 3));
  scenes.push_back({"huge", huge, front_camera(640, 400)});
  CountedScene antialiased{"antialiased", cloud, front_camera(133, 97)};
  antialiased.settings.antialiased = true;
  antialiased.settings.splat_scale = 0.3f;
  scenes.push_back(antialiased);
  CountedScene sharp{"without dilation", cloud, front_camera(133, 97)};
  sharp.settings.dilation = 0;
  scenes.push_back(sharp);
  CountedScene shifted{"off centre", cloud, front_camera(200, 120)};
  shifted.camera.center_px = {-40, 170};
  shifted.camera.focal_px.y *= 1.5;
  scenes.push_back(shifted);
  return scenes;
}

}  // namespace test
}  // namespace qs
