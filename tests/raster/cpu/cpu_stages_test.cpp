// SPDX-License-Identifier: MIT
// Parts of the CPU backend by themselves: sorting, the limit of memory, the order of tiles.
#include <algorithm>
#include <bit>
#include <random>

#include <gtest/gtest.h>
#include <unistd.h>

#include "base/error.h"
#include "raster/cpu/common/tile_lists.h"
#include "raster/cpu/fast/pipeline.h"
#include "raster/scene/radix_sort.h"
#include "support/pool.h"
#include "support/scenes.h"

namespace qs {
namespace {

/// Random keys in [low, high]; values number the items.
SortItems random_items(std::size_t count, std::uint32_t low, std::uint32_t high) {
  std::mt19937 random(static_cast<unsigned>(count));
  std::uniform_int_distribution<std::uint32_t> key(low, high);
  SortItems items;
  items.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    items.keys[i] = key(random);
    items.values[i] = static_cast<std::uint32_t>(i);
  }
  return items;
}

TEST(RadixSort, is_stable_for_every_width_of_keys_and_number_of_threads) {
  for (const int bits : {0, 1, 10, 11, 12, 22, 23, 31, 32}) {
    const std::uint32_t width = bits == 0 ? 0 : ~0u >> (32 - bits);
    for (const std::uint32_t low : {0u, 77u, ~0u - width}) {
      if (low > ~0u - width) continue;
      for (const std::size_t count : {0u, 1u, 2u, 5000u}) {
        for (const int threads : {1, 3}) {
          SortItems items = random_items(count, low, low + width);
          std::vector<std::pair<std::uint32_t, std::uint32_t>> expected, got;
          for (std::size_t i = 0; i < count; ++i)
            expected.emplace_back(items.keys[i], items.values[i]);
          std::stable_sort(expected.begin(), expected.end(),
                           [](const auto& a, const auto& b) { return a.first < b.first; });
          radix_sort(items, {low, low + width}, test::pool(threads));
          for (std::size_t i = 0; i < count; ++i) got.emplace_back(items.keys[i], items.values[i]);
          EXPECT_EQ(got, expected) << bits << " bits from " << low << ", " << threads << " threads";
        }
      }
    }
  }
}

TEST(RadixSort, can_be_cancelled) {
  SortItems items = random_items(100, 0, ~0u);
  std::stop_source source;
  source.request_stop();
  EXPECT_THROW(radix_sort(items, {0, ~0u}, test::pool(2), source.get_token()), Cancelled);
}

TEST(KeyRange, of_keys_is_their_smallest_and_largest) {
  KeyRange range;
  for (const std::uint32_t key : {7u, 3u, 12u}) range.include(key);
  range.include(KeyRange());
  EXPECT_EQ(range.low, 3u);
  EXPECT_EQ(range.high, 12u);
}

TEST(TileLists, may_take_half_of_the_memory_of_the_machine) {
  const std::uint64_t memory = static_cast<std::uint64_t>(sysconf(_SC_PHYS_PAGES)) *
                               static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
  const std::uint64_t most = memory / 2 / 4;  // of 4 bytes each
  EXPECT_NO_THROW(cpu::refuse_if_too_many(most));
  EXPECT_THROW(cpu::refuse_if_too_many(most + 1), Error);
}

TEST(Sort, lists_in_every_band_the_gaussians_that_reach_it_front_to_back) {
  const GaussianCloud cloud = test::random_cloud(5000, 0, 4);
  const RenderSettings settings;
  for (const auto& [height, threads] : {std::pair{200, 1}, {200, 3}, {40, 5}}) {
    const Camera camera = test::front_camera(320, height);
    const cpu::FrameContext frame{cloud,
                                  camera,
                                  settings,
                                  TileGrid::of_image(camera.width, camera.height),
                                  test::pool(threads),
                                  {}};
    cpu::fast::FastVisible visible;
    cpu::fast::Bands bands;
    cpu::fast::preprocess(frame, cpu::fast::make_scene(cloud, test::pool(2)), false, visible);
    cpu::fast::sort(frame, visible, bands);
    ASSERT_EQ(bands.size(), static_cast<std::size_t>(threads));
    int row = 0;
    for (const auto& band : bands) {
      EXPECT_EQ(band->top, row);
      row = band->bottom;
      std::vector<std::uint32_t> expected;
      visible.for_each([&](std::uint32_t slot) {
        const auto begin = static_cast<int>(visible.rows[slot] & 0xffff);
        const auto end = static_cast<int>(visible.rows[slot] >> 16);
        EXPECT_LT(begin, end);
        if (begin < band->bottom && end > band->top) expected.push_back(slot);
      });
      std::sort(expected.begin(), expected.end(), [&](std::uint32_t a, std::uint32_t b) {
        return std::pair(visible.depths[a], visible.gaussians[a]) <
               std::pair(visible.depths[b], visible.gaussians[b]);
      });
      EXPECT_EQ(std::vector<std::uint32_t>(band->slots().begin(), band->slots().end()), expected);
    }
    EXPECT_EQ(row, frame.grid.rows);
  }
}

TEST(Blend, takes_tiles_by_descending_class_of_length_and_then_in_order) {
  const GaussianCloud cloud = test::random_cloud(4000, 0, 3);
  const Camera camera = test::front_camera(320, 200);
  const RenderSettings settings;
  const cpu::FrameContext frame{
      cloud, camera, settings, TileGrid::of_image(camera.width, camera.height), test::pool(2), {}};
  const cpu::fast::SceneBlocks scene = cpu::fast::make_scene(cloud, test::pool(2));
  cpu::fast::FastVisible visible;
  cpu::fast::Bands bands;
  cpu::TileLists lists;
  cpu::fast::TileQueue queue;
  Frame result;
  Outputs outputs;
  outputs.color = false;
  cpu::fast::preprocess(frame, scene, false, visible);
  cpu::fast::sort(frame, visible, bands);
  cpu::fast::bin(frame, visible, bands, lists);
  cpu::fast::blend(frame, visible, lists, queue, outputs, result);
  std::vector<std::uint32_t> expected(static_cast<std::size_t>(frame.grid.count()));
  for (std::uint32_t tile = 0; tile < expected.size(); ++tile) expected[tile] = tile;
  std::stable_sort(expected.begin(), expected.end(), [&](std::uint32_t a, std::uint32_t b) {
    return std::bit_width(lists.pairs(a)) > std::bit_width(lists.pairs(b));
  });
  EXPECT_EQ(std::vector<std::uint32_t>(queue.tiles.begin(), queue.tiles.end()), expected);
}

}  // namespace
}  // namespace qs
