// SPDX-License-Identifier: MIT
// Other tile sizes, and regions of mode reference, on the CPU backend.
#include <gtest/gtest.h>

#include "base/error.h"
#include "raster/api/renderer.h"
#include "support/pool.h"
#include "support/scenes.h"

namespace qs {
namespace {

Frame render(const GaussianCloud& cloud, const Camera& camera, CullMode mode, int tile_px) {
  const auto renderer = make_renderer(Backend::cpu, test::pool(2));
  renderer->upload(cloud, {});
  RenderSettings settings;
  settings.mode = mode;
  settings.tile_px = tile_px;
  settings.pipeline = Pipeline::classic;  // the only pipeline with other tile sizes
  Outputs outputs;
  outputs.pairs = outputs.used = outputs.trace = true;
  return renderer->render(camera, settings, outputs);
}

TEST(TileSize, lossless_modes_draw_the_same_image_with_any) {
  const GaussianCloud cloud = test::random_cloud(3000, 1, 21);
  const Camera camera = test::front_camera(133, 97);
  for (CullMode mode = 1; mode <= culler_count(); ++mode) {
    if (!row_of(mode).lossless) continue;
    const Image usual = render(cloud, camera, mode, kTileSize).color;
    for (const int tile_px : kTileSizes)
      EXPECT_EQ(render(cloud, camera, mode, tile_px).color.values, usual.values)
          << mode_name(mode) << " " << tile_px;
  }
}

TEST(TileSize, lists_cover_the_image_and_nest_as_the_modes_promise) {
  const GaussianCloud cloud = test::random_cloud(3000, 0, 22);
  const Camera camera = test::front_camera(320, 200);
  for (const int tile_px : kTileSizes) {
    const auto pairs = [&](const char* name) {
      const Frame frame = render(cloud, camera, find_culler(name), tile_px);
      EXPECT_EQ(frame.grid.tile_px, tile_px);
      EXPECT_EQ(frame.grid.columns, (camera.width + tile_px - 1) / tile_px);
      EXPECT_EQ(frame.pairs.size(), static_cast<std::size_t>(frame.grid.count()));
      EXPECT_EQ(sum_of(frame.pairs), frame.stats.tile_pairs);
      EXPECT_LE(*frame.stats.used_pairs, frame.stats.tile_pairs);
      return frame.stats.tile_pairs;
    };
    EXPECT_LE(pairs("exact"), pairs("quadbox"));
    EXPECT_EQ(pairs("quadbox"), pairs("quadbox-naive"));
    EXPECT_LE(pairs("quadbox"), pairs("adr"));
    EXPECT_LE(pairs("dualbox"), pairs("quadbox"));
  }
}

TEST(TileSize, smaller_tiles_give_more_pairs) {
  const GaussianCloud cloud = test::random_cloud(3000, 0, 23);
  const Camera camera = test::front_camera(320, 200);
  for (CullMode mode = 1; mode <= culler_count(); ++mode) {
    const auto pairs = [&](int px) { return render(cloud, camera, mode, px).stats.tile_pairs; };
    EXPECT_GT(pairs(8), pairs(16)) << mode_name(mode);
    EXPECT_GT(pairs(16), pairs(32)) << mode_name(mode);
  }
}

TEST(TileSize, an_unsupported_size_is_refused_with_a_sentence) {
  try {
    render(test::random_cloud(10, 0, 1), test::front_camera(32, 32), default_mode(), 12);
    FAIL() << "no error";
  } catch (const Error& error) {
    EXPECT_STREQ(error.what(), "backend cpu: cannot use tiles of 12 pixels, only 8, 16 or 32");
  }
}

TEST(Region, of_the_reference_is_what_the_whole_image_has_there) {
  const auto renderer = make_renderer(Backend::cpu, test::pool(2));
  renderer->upload(test::random_cloud(2000, 1, 24), {});
  const Camera camera = test::front_camera(120, 90);
  RenderSettings settings;
  settings.mode = kReferenceMode;
  settings.background = {0.2f, 0.4f, 0.6f};
  const Image whole = renderer->render(camera, settings).color;
  for (const PixelBox box :
       {PixelBox{30, 20, 31, 21}, {0, 0, 40, 90}, {100, 80, 500, 500}, {50, 50, 50, 60}}) {
    Outputs outputs;
    outputs.region = box;
    const Image part = renderer->render(camera, settings, outputs).color;
    for (int y = 0; y < camera.height; ++y) {
      for (int x = 0; x < camera.width; ++x) {
        const bool inside = x >= box.x0 && x < box.x1 && y >= box.y0 && y < box.y1;
        for (int c = 0; c < 3; ++c)
          ASSERT_EQ(part.at(x, y, c), inside ? whole.at(x, y, c) : 0) << x << "," << y;
      }
    }
  }
}

}  // namespace
}  // namespace qs
