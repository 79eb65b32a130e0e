// SPDX-License-Identifier: MIT
// The properties that the modes of other papers share with our modes and with each other, on
// footprints that single precision can describe. culler_test.cpp has the properties of all modes.
// Not in checked: thousands of footprints take long there; mode_pairs_test.cpp runs the same code.
#include <algorithm>
#include <set>

#include <gtest/gtest.h>

#include "raster/kernel/cull/modes.h"
#include "support/footprints.h"

namespace qs {
namespace {

constexpr int kWidth = 320, kHeight = 200;
constexpr float kThickest = 1e-3f;  // f^2 below which a footprint counts as a needle here

template <class P>
std::set<int> tiles_listed_by(const Footprint& footprint, TileGrid grid) {
  std::set<int> tiles;
  for_each_tile<P>(footprint, grid, [&](int tile) { tiles.insert(tile); });
  return tiles;
}

bool all_in(const std::set<int>& outer, const std::set<int>& inner) {
  return std::includes(outer.begin(), outer.end(), inner.begin(), inner.end());
}

/// Calls check(footprint, grid) for 600 footprints of every kind that are not needles.
template <class Check>
void for_each_thick_footprint(const Check& check) {
  const TileGrid grid = TileGrid::of_image(kWidth, kHeight);
  for (const test::FootprintKind& kind : test::footprint_kinds()) {
    std::mt19937 random(7);
    int tried = 0;
    for (int draw = 0; draw < 600; ++draw) {
      const Footprint footprint = kind.draw(random, kWidth, kHeight);
      const Covariance2<float>& s = footprint.covariance;
      if (footprint.determinant < kThickest * s.xx * s.yy) continue;
      SCOPED_TRACE(testing::Message() << kind.name << " draw " << draw);
      check(footprint, grid);
      if (testing::Test::HasFailure()) return;
      ++tried;
    }
    EXPECT_GT(tried, 100) << kind.name;
  }
}

TEST(Peers, lose_no_visible_pixel_of_a_gaussian_that_is_no_needle) {
  for_each_thick_footprint([](const Footprint& footprint, TileGrid grid) {
    const float opacity = test::opacity_of(footprint);
    std::set<int> needed;
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        if (test::alpha_at(footprint, opacity, x, y) >= kAlphaMin)
          needed.insert(grid.tile_of(x, y));
      }
    }
    EXPECT_TRUE(all_in(tiles_listed_by<SnugBox>(footprint, grid), needed));
    EXPECT_TRUE(all_in(tiles_listed_by<AccuTile>(footprint, grid), needed));
    EXPECT_TRUE(all_in(tiles_listed_by<FlashGs>(footprint, grid), needed));
    EXPECT_TRUE(all_in(tiles_listed_by<StopThePop>(footprint, grid), needed));
    EXPECT_TRUE(all_in(tiles_listed_by<FasterGs>(footprint, grid), needed));
  });
}

TEST(Peers, list_the_same_tiles_where_their_statements_agree) {
  for_each_thick_footprint([](const Footprint& footprint, TileGrid grid) {
    EXPECT_EQ(tiles_listed_by<AccuTile>(footprint, grid),
              tiles_listed_by<FlashGs>(footprint, grid));
    EXPECT_EQ(tiles_listed_by<StopThePop>(footprint, grid),
              tiles_listed_by<FasterGs>(footprint, grid));
  });
}

TEST(Peers, nest_from_squares_of_pixel_centres_to_boxes) {
  for_each_thick_footprint([](const Footprint& footprint, TileGrid grid) {
    const std::set<int> accutile = tiles_listed_by<AccuTile>(footprint, grid);
    const std::set<int> centers = tiles_listed_by<FasterGs>(footprint, grid);
    EXPECT_TRUE(all_in(tiles_listed_by<Exact>(footprint, grid), centers));
    EXPECT_TRUE(all_in(accutile, centers));
    EXPECT_TRUE(all_in(tiles_listed_by<SnugBox>(footprint, grid), accutile));
  });
}

/// Compares a walk that tests tiles from the ends of a line with a test of every tile.
template <class P>
void expect_every_passing_tile(const Footprint& footprint, TileGrid grid) {
  const auto walk = P::walk(footprint, grid);
  const TileRect box = TileRect::of_lines(walk.by_rows, walk.lines, walk.tiles);
  std::set<int> passing;
  for (int tile = 0; tile < grid.count(); ++tile) {
    const int column = tile % grid.columns, row = tile / grid.columns;
    if (box.contains(column, row) && walk.test.meets(column, row)) passing.insert(tile);
  }
  EXPECT_EQ(tiles_listed_by<P>(footprint, grid), passing) << P::kName;
}

TEST(Peers, that_test_tiles_list_every_tile_of_their_box_that_passes) {
  for_each_thick_footprint([](const Footprint& footprint, TileGrid grid) {
    expect_every_passing_tile<FlashGs>(footprint, grid);
    expect_every_passing_tile<StopThePop>(footprint, grid);
    expect_every_passing_tile<FasterGs>(footprint, grid);
  });
}

}  // namespace
}  // namespace qs
