// SPDX-License-Identifier: MIT
// The culling mode that docs/extending.md shows, added to the tables as that page says. Nothing
// else changes, and all that iterates over modes has it. The tests of culler_test.cpp run for it
// too.
#include <set>
#include <string>

#include <gtest/gtest.h>

#include "app/inspect/gaussian.h"
#include "app/picture/palette.h"
#include "raster/kernel/cull/mode.h"
#include "raster/kernel/cull/modes.h"
#include "support/cull_vectors.h"
#include "support/footprints.h"

namespace qs {
namespace {

constexpr CullMode kNew = number_of("opacity-square");

TEST(NewMode, has_the_number_and_key_behind_exact_and_moves_the_peers) {
  EXPECT_EQ(kNew, find_culler("exact") + 1);
  EXPECT_LE(kNew, culler_count());
  EXPECT_EQ(row_of(kNew).family, CullerFamily::quadbox);
  EXPECT_EQ(row_of(culler_count() + 1).family, CullerFamily::peers);
  EXPECT_STREQ(mode_name(default_mode()), "quadbox");
}

TEST(NewMode, is_one_more_beside_those_of_the_test_vectors) {
  std::set<std::string> names;
  for (CullMode mode = 1; mode <= mode_count(); ++mode) names.insert(mode_name(mode));
  EXPECT_EQ(names.size(), static_cast<std::size_t>(mode_count())) << "two modes have the same name";
  EXPECT_EQ(names.erase("opacity-square"), 1u);
  std::set<std::string> known;
  for (const auto& [name, map] : test::read_cull_vectors().map_of_mode) known.insert(name);
  EXPECT_EQ(names, known);
}

TEST(NewMode, has_the_colour_of_its_row_and_the_others_keep_theirs) {
  EXPECT_EQ(mode_color(kNew), rgb(row_of(kNew).color));
  EXPECT_EQ(mode_color(find_culler("exact")), kVermillion);
  EXPECT_EQ(mode_color(find_culler("snugbox")), rgb(0x8FC9A0));
  EXPECT_EQ(mode_color(find_culler("faster-gs")), rgb(0xB5838D));
  for (CullMode mode = 0; mode <= mode_count(); ++mode) {
    EXPECT_EQ(mode_color(mode) == mode_color(kNew), mode == kNew) << mode_name(mode);
  }
}

TEST(NewMode, is_found_by_the_inspector_and_lists_a_square_around_the_box_of_adr) {
  const TileGrid grid = TileGrid::of_image(640, 480);
  const Footprint needle = test::make_footprint({320, 240}, 60, 2, 0.3, 0.9);
  const auto tiles_of = [&](const char* mode) {
    const std::vector<int> tiles = mode_tiles(find_culler(mode), needle, grid).tiles;
    return std::set<int>(tiles.begin(), tiles.end());
  };
  const std::set<int> square = tiles_of("opacity-square");
  for (const int tile : tiles_of("adr")) EXPECT_TRUE(square.contains(tile)) << tile;
  EXPECT_GT(square.size(), tiles_of("adr").size());
  EXPECT_EQ(count_mode_tiles(kNew, needle, grid), square.size());
}

TEST(NewMode, takes_part_in_the_proof_that_structs_and_rows_agree) {
  EXPECT_TRUE(agrees_with_table(AllCullers()));
  EXPECT_EQ(&row_of<OpacitySquare>(), &row_of(kNew));
  EXPECT_TRUE(row_of<OpacitySquare>().lossless);
}

}  // namespace
}  // namespace qs
