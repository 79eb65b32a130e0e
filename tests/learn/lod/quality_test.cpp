// SPDX-License-Identifier: MIT
//
// Pictures of cuts of a tree of plush_big against its full pictures, as docs/lod.md prints them:
//   quadsplat lod ../shared/scenes/plush_big.spz big.rad
//   QUADSPLAT_LOD_QUALITY=big.rad build/optimised/learn_tests --gtest_filter=LodQuality*
// With QUADSPLAT_LOD_ANTIALIASED=1 both are drawn antialiased.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "io/camera/cameras.h"
#include "io/scene/reader.h"
#include "learn/lod/cut.h"
#include "raster/api/renderer.h"
#include "raster/scene/image_metrics.h"
#include "support/lod_cuts.h"
#include "support/pool.h"
#include "support/shared.h"

namespace qs::test {
namespace {

struct Distance {
  const char* name;
  double factor;                 // of the distance between camera and subject
  std::array<double, 4> target;  // dB at the budgets: 1 dB above the best column of other programs
  std::vector<Camera> views = {};
  std::vector<Image> pictures = {};
  double footprint = 0;
};
constexpr std::array kBudgets = {0.05, 0.10, 0.25, 0.50};

Image picture_of(Renderer& renderer, const Camera& camera, const RenderSettings& settings) {
  Image image = renderer.render(camera, settings).color;
  clamp_to_unit(image);
  return image;
}

// The median depth of the picture's centre.
double depth_ahead(Renderer& renderer, const Camera& camera, const RenderSettings& settings) {
  Outputs outputs;
  outputs.depth = true;
  const Frame& frame = renderer.render(camera, settings, outputs);
  std::vector<float> depths;
  for (int y = 200; y < 400; ++y)
    for (int x = 270; x < 530; ++x)
      if (const float z = frame.depth.median[static_cast<std::size_t>(800 * y + x)]; z > 0)
        depths.push_back(z);
  const auto middle = depths.begin() + static_cast<std::ptrdiff_t>(depths.size() / 2);
  std::nth_element(depths.begin(), middle, depths.end());
  return static_cast<double>(*middle);
}

TEST(LodQuality, of_plush_big_at_three_distances) {
  const char* const tree = std::getenv("QUADSPLAT_LOD_QUALITY");
  if (tree == nullptr) GTEST_SKIP() << "QUADSPLAT_LOD_QUALITY names no tree of plush_big";
  QS_NEEDS_SHARED("scenes/plush_big.spz");
  RenderSettings settings;
  settings.antialiased = std::getenv("QUADSPLAT_LOD_ANTIALIASED") != nullptr;
  const auto renderer = make_renderer(Backend::cpu, pool());
  Scene full = read_scene(shared_path("scenes/plush_big.spz"), pool());
  const auto leaves = static_cast<double>(full.cloud.size());
  renderer->upload(std::move(full.cloud), {});
  std::vector<Distance> distances = {{"near", 1, {30.24, 32.52, 37.02, 41.33}},
                                     {"middle", 4, {33.27, 35.47, 39.82, 45.37}},
                                     {"far", 16, {39.50, 42.10, 46.92, 52.89}}};
  const std::vector<Camera> cameras = read_cameras(shared_path("scenes/plush/cameras.json"));
  for (const std::size_t number : {0, 24, 48, 80}) {
    Camera camera = cameras.at(number);
    const double depth = depth_ahead(*renderer, camera.resized(800, 600), settings);
    camera.focal_px = glm::dvec2(camera.focal_px.x * 800 / camera.width);
    camera.width = 800;
    camera.height = 600;
    camera.center_px = {399.5, 299.5};
    for (Distance& distance : distances) {
      Camera moved = camera;
      moved.view_from_world[3][2] += depth * (distance.factor - 1);
      distance.footprint += depth * distance.factor / camera.focal_px.x / 4;
      distance.views.push_back(moved);
      distance.pictures.push_back(picture_of(*renderer, moved, settings));
    }
  }
  const LodPages pages = whole_tree(tree);
  const double dilation = *settings.antialiased ? 0 : settings.dilation;
  for (const bool sees : {false, true}) {
    for (const Distance& distance : distances) {
      const LodView even = even_view(static_cast<float>(distance.footprint));
      std::vector<LodView> views;
      for (const Camera& camera : distance.views) views.emplace_back(camera, 1e-4f);
      const LodGain gain = sees ? gain_in(views, pages.footprint) : gain_in(even, pages.footprint);
      fmt::print("| {} | {} |", sees ? "views" : "footprint", distance.name);
      for (std::size_t b = 0; b < kBudgets.size(); ++b) {
        const auto budget = static_cast<std::size_t>(std::lround(kBudgets[b] * leaves));
        const LodCut cut = cut_of(pages, gain, {budget}, pool());
        double mean = 0;
        for (std::size_t v = 0; v < views.size(); ++v) {
          renderer->upload(cut_cloud(pages, cut, sees ? views[v] : even, dilation, pool()), {});
          mean += psnr(picture_of(*renderer, distance.views[v], settings), distance.pictures[v],
                       pool()) /
                  4;
        }
        fmt::print(" {:.2f} ({:+.2f}) |", mean, mean - distance.target[b]);
        EXPECT_GT(mean, distance.target[b] - (sees ? 2 : 4)) << distance.name;
      }
      fmt::print("\n");
    }
  }
}

}  // namespace
}  // namespace qs::test
