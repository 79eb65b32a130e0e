// SPDX-License-Identifier: MIT
// The culling mode that docs/extending.md shows, added to the tables as that page says. Nothing
// else changes, and all that iterates over modes has it. The tests of culler_test.cpp run for it
// too.
#include <cstdlib>
#include <fstream>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest-spi.h>
#include <gtest/gtest.h>

#include "app/inspect/gaussian.h"
#include "app/picture/palette.h"
#include "raster/kernel/cull/mode.h"
#include "raster/kernel/cull/modes.h"
#include "support/cull_vectors.h"
#include "support/footprints.h"
#include "support/golden.h"
#include "support/temporary_folder.h"

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

TEST(NewMode, has_its_key_in_the_table_of_viewer_md_behind_the_keys_of_the_others) {
  std::ifstream page(NEW_MODE_VIEWER_PAGE);
  std::vector<std::string> keys, expected;
  const std::regex row("\\| `[1-9]` \\| [a-z0-9-]+ \\|");
  for (std::string line; std::getline(page, line);) {
    if (std::regex_match(line, row)) keys.push_back(line);
  }
  for (CullMode mode = 1; mode <= culler_count(); ++mode)
    expected.push_back(fmt::format("| `{}` | {} |", mode, mode_name(mode)));
  EXPECT_EQ(keys, expected);
}

// The modes as a golden text.
std::string list_of_modes(bool with_new) {
  std::string text;
  for (CullMode mode = 1; mode <= mode_count(); ++mode) {
    if (with_new || mode != kNew)
      text += fmt::format("{:14} {}\n", mode_name(mode), row_of(mode).summary);
  }
  return text;
}

TEST(NewMode, makes_golden_texts_that_list_the_modes_fail_until_they_are_accepted) {
  const TemporaryFolder folder;
  std::ofstream(folder / "modes.txt") << list_of_modes(false);
  setenv("QUADSPLAT_GOLDEN_FOLDER", folder.path().c_str(), 1);
  static const std::string now = list_of_modes(true);
  EXPECT_NONFATAL_FAILURE(test::expect_golden_text("modes.txt", now), "opacity-square");
  setenv("QUADSPLAT_UPDATE_GOLDEN", "1", 1);
  test::expect_golden_text("modes.txt", now);
  unsetenv("QUADSPLAT_UPDATE_GOLDEN");
  test::expect_golden_text("modes.txt", now);
  unsetenv("QUADSPLAT_GOLDEN_FOLDER");
}

TEST(NewMode, takes_part_in_the_proof_that_structs_and_rows_agree) {
  EXPECT_TRUE(agrees_with_table(AllCullers()));
  EXPECT_EQ(&row_of<OpacitySquare>(), &row_of(kNew));
  EXPECT_TRUE(row_of<OpacitySquare>().lossless);
}

}  // namespace
}  // namespace qs
