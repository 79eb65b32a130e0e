// SPDX-License-Identifier: MIT
// Property tests of all culling modes with difficult footprints and grids.
// Not in checked: thousands of footprints take long there; mode_pairs_test.cpp runs the same code.
#include <algorithm>
#include <set>

#include <gtest/gtest.h>

#include "raster/kernel/cull/mode.h"
#include "raster/kernel/cull/modes.h"
#include "support/footprints.h"

namespace qs {
namespace {

struct Size {
  int width, height;
};

constexpr Size kSizes[] = {{1, 1}, {17, 33}, {640, 97}, {97, 640}, {256, 256}};
constexpr int kCullerDraws = 600;      // per kind and size
constexpr int kBruteForceDraws = 150;  // for tests that try every pixel

template <class P>
std::vector<int> tiles_of(const Footprint& footprint, TileGrid grid) {
  std::vector<int> tiles;
  for_each_tile<P>(footprint, grid, [&](int tile) { tiles.push_back(tile); });
  return tiles;
}

template <class P>
std::set<int> tile_set(const Footprint& footprint, TileGrid grid) {
  const std::vector<int> tiles = tiles_of<P>(footprint, grid);
  return {tiles.begin(), tiles.end()};
}

/// Calls check(footprint, grid, size) for every kind, size and draw. Ends a kind at its first
/// failure.
template <class Check>
void for_each_footprint(const Check& check, int draws = kCullerDraws) {
  for (const test::FootprintKind& kind : test::footprint_kinds()) {
    for (const Size size : kSizes) {
      std::mt19937 random(20260504);
      const TileGrid grid = TileGrid::of_image(size.width, size.height);
      for (int draw = 0; draw < draws; ++draw) {
        SCOPED_TRACE(testing::Message()
                     << kind.name << " " << size.width << "x" << size.height << " draw " << draw);
        check(kind.draw(random, size.width, size.height), grid, size);
        if (testing::Test::HasFailure()) return;
      }
    }
  }
}

bool includes(const std::set<int>& outer, const std::set<int>& inner) {
  return std::includes(outer.begin(), outer.end(), inner.begin(), inner.end());
}

template <class P>
class CullerTest : public testing::Test {};

template <class Tuple>
struct AsTypes;
template <class... P>
struct AsTypes<std::tuple<P...>> {
  using type = testing::Types<P...>;
};

struct ModeNames {
  template <class P>
  static std::string GetName(int) {
    std::string name = P::kName;
    std::replace(name.begin(), name.end(), '-', '_');
    return name;
  }
};

TYPED_TEST_SUITE(CullerTest, AsTypes<AllCullers>::type, ModeNames);

TYPED_TEST(CullerTest, lists_each_tile_once_inside_the_grid_and_counts_what_it_lists) {
  for_each_footprint([](const Footprint& footprint, TileGrid grid, Size) {
    const std::vector<int> tiles = tiles_of<TypeParam>(footprint, grid);
    const std::set<int> set(tiles.begin(), tiles.end());
    EXPECT_EQ(set.size(), tiles.size()) << "a tile was listed twice";
    EXPECT_EQ(tiles.size(), count_tiles<TypeParam>(footprint, grid));
    if (!set.empty()) {
      EXPECT_GE(*set.begin(), 0);
      EXPECT_LT(*set.rbegin(), grid.count());
    }
  });
}

/// The tiles with a pixel whose alpha is >= 1/255, by trying every pixel.
std::set<int> needed_tiles(const Footprint& footprint, TileGrid grid, Size size) {
  const float opacity = test::opacity_of(footprint);
  const auto is_needed = [&](int x0, int y0) {
    for (int y = y0; y < std::min(y0 + kTileSize, size.height); ++y) {
      for (int x = x0; x < std::min(x0 + kTileSize, size.width); ++x) {
        if (test::alpha_at(footprint, opacity, x, y) >= kAlphaMin) return true;
      }
    }
    return false;
  };
  std::set<int> tiles;
  for (int tile = 0; tile < grid.count(); ++tile) {
    if (is_needed(tile % grid.columns * kTileSize, tile / grid.columns * kTileSize))
      tiles.insert(tile);
  }
  return tiles;
}

/// needed_tiles() of the first kBruteForceDraws draws, in the order of for_each_footprint().
/// Computed once for all modes, because it takes longer than everything else here.
const std::vector<std::set<int>>& needed_by_draw() {
  static const std::vector<std::set<int>> needed = [] {
    std::vector<std::set<int>> all;
    for_each_footprint([&](const auto&... draw) { all.push_back(needed_tiles(draw...)); },
                       kBruteForceDraws);
    return all;
  }();
  return needed;
}

TYPED_TEST(CullerTest, has_bounds_that_contain_its_tiles_and_are_empty_without_any) {
  using P = TypeParam;
  for_each_footprint([](const Footprint& footprint, TileGrid grid, Size) {
    const TileRect rect = bounds<P>(footprint, grid);
    const std::vector<int> tiles = tiles_of<P>(footprint, grid);
    EXPECT_EQ(rect.is_empty(), tiles.empty());
    for (const int tile : tiles) {
      EXPECT_TRUE(rect.contains(tile % grid.columns, tile / grid.columns)) << tile;
    }
  });
}

TEST(Cullers, the_naive_loop_over_windows_lists_every_tile_once) {
  for_each_footprint([](const Footprint& footprint, TileGrid grid, Size) {
    std::vector<int> tiles;
    for (int row = 0; row < grid.rows; row += 2) {
      for (int column = 0; column < grid.columns; column += 3) {
        const TileRect window{{column, column + 3}, {row, row + 2}};
        QuadBoxNaive::for_each_tile_in(footprint, grid, window, [&](int x, int y) {
          EXPECT_TRUE(window.contains(x, y));
          tiles.push_back(y * grid.columns + x);
        });
      }
    }
    std::sort(tiles.begin(), tiles.end());
    std::vector<int> expected = tiles_of<QuadBox>(footprint, grid);
    std::sort(expected.begin(), expected.end());
    EXPECT_EQ(tiles, expected);
  });
}

/// 3,000 times as long as wide: rounding makes every mode without a widened box lose tiles of it.
bool loses_tiles_of_a_needle(const auto& listed_by) {
  const Footprint needle = qs::make_footprint(
      {226.500351f, 533.835144f}, {2151630.25f, -1031990.38f, 494975.812f}, 0.366540462f);
  const Size size{1640, 640};
  const TileGrid grid = TileGrid::of_image(size.width, size.height);
  return !includes(listed_by(needle, grid), needed_tiles(needle, grid, size));
}

TYPED_TEST(CullerTest, loses_visible_pixels_exactly_when_the_table_says_so) {
  auto needed = needed_by_draw().begin();
  int losses = loses_tiles_of_a_needle(tile_set<TypeParam>);
  for_each_footprint(
      [&](const Footprint& footprint, TileGrid grid, Size) {
        const bool loses = !includes(tile_set<TypeParam>(footprint, grid), *needed++);
        losses += loses;
        EXPECT_FALSE(loses && row_of<TypeParam>().lossless);
      },
      kBruteForceDraws);
  EXPECT_EQ(losses == 0, row_of<TypeParam>().lossless);
}

TEST(Cullers, qpass_lists_the_same_tiles_as_the_naive_loop) {
  for_each_footprint([](const Footprint& footprint, TileGrid grid, Size) {
    EXPECT_EQ(tile_set<QuadBox>(footprint, grid), tile_set<QuadBoxNaive>(footprint, grid));
  });
}

TEST(Cullers, nest_exact_in_quadbox_in_adr_and_dualbox_in_quadbox) {
  for_each_footprint([](const Footprint& footprint, TileGrid grid, Size) {
    const std::set<int> quad = tile_set<QuadBox>(footprint, grid);
    EXPECT_TRUE(includes(quad, tile_set<Exact>(footprint, grid)));
    EXPECT_TRUE(includes(tile_set<AdrAabb>(footprint, grid), quad));
    EXPECT_TRUE(includes(quad, tile_set<DualBox>(footprint, grid)));
  });
}

TEST(Cullers, exact_lists_little_more_than_the_tiles_that_need_it) {
  // Brute force: a tile is needed if one of its pixels has alpha >= 1/255.
  std::size_t listed = 0, needed = 0;
  std::mt19937 random(7);
  const TileGrid grid = TileGrid::of_image(256, 256);
  for (int draw = 0; draw < 300; ++draw) {
    const Footprint footprint =
        test::footprint_kinds()[static_cast<std::size_t>(draw % 2)].draw(random, 256, 256);
    const float opacity = test::opacity_of(footprint);
    std::set<int> tiles;
    for (int y = 0; y < 256; ++y) {
      for (int x = 0; x < 256; ++x) {
        if (test::alpha_at(footprint, opacity, x, y) >= kAlphaMin)
          tiles.insert(y / 16 * 16 + x / 16);
      }
    }
    listed += tile_set<Exact>(footprint, grid).size();
    needed += tiles.size();
  }
  EXPECT_GE(listed, needed);
  EXPECT_LT(static_cast<double>(listed),
            1.2 * static_cast<double>(needed));  // corners between pixel centres
}

TEST(Cullers, the_closed_forms_of_f_agree_with_the_ellipse) {
  std::mt19937 random(3);
  for (int draw = 0; draw < 2000; ++draw) {
    const Footprint footprint = test::footprint_kinds()[0].draw(random, 640, 480);
    const double sxx = footprint.covariance.xx, sxy = footprint.covariance.xy,
                 syy = footprint.covariance.yy;
    const double det = sxx * syy - sxy * sxy, a = syy / det, b = -sxy / det, c = sxx / det,
                 gamma = footprint.gamma;
    const double x_max = std::sqrt(gamma * c / (a * c - b * b)),
                 y_max = std::sqrt(gamma * a / (a * c - b * b));
    const double rho = sxy / std::sqrt(sxx * syy);
    const Extents e = extents(footprint);
    EXPECT_NEAR(e.max.x, x_max, 1e-4 * x_max);
    EXPECT_NEAR(e.max.y, y_max, 1e-4 * y_max);
    const double f = static_cast<double>(e.f);
    EXPECT_NEAR(f, std::sqrt(gamma / a) / x_max, 1e-4);
    EXPECT_NEAR(f, std::sqrt(gamma / c) / y_max, 1e-4);
    EXPECT_NEAR(f, std::sqrt(1 - b * b / (a * c)), 1e-4);
    EXPECT_NEAR(f, std::sqrt(1 - rho * rho), 1e-4);
  }
}

TEST(Cullers, the_square_follows_the_integer_rule_of_3dgs) {
  // Half side ceil(3 sqrt(lambda_max)) = 3 * 2 = 6 around (20, 20): pixels 14..26, tiles 0 and 1.
  Footprint footprint = test::make_footprint({20, 20}, 0, 0, 0, 1);
  footprint.covariance = {4, 0, 4};
  footprint.determinant = 16;
  // mid = 4, root = sqrt(max(0.1, 0)): lambda = 4.316, radius = ceil(6.23) = 7: 13..27 -> tiles
  // 0..1.
  EXPECT_EQ(Square::radius(footprint), 7.0f);
  EXPECT_EQ(tiles_of<Square>(footprint, TileGrid::of_image(64, 64)),
            (std::vector<int>{0, 1, 4, 5}));
  footprint.mean_px = {-30, 20};  // int() truncates (-22)/16 to -1: clamped, no tile
  EXPECT_TRUE(tiles_of<Square>(footprint, TileGrid::of_image(64, 64)).empty());
}

TEST(Cullers, the_table_finds_every_mode_by_its_name_and_nothing_else) {
  for (int mode = 0; mode <= mode_count(); ++mode) {
    EXPECT_EQ(find_culler(mode_name(mode)), mode);
  }
  EXPECT_EQ(find_culler("quad"), -1);
  EXPECT_EQ(find_culler(""), -1);
  EXPECT_STREQ(row_of(default_mode()).name, "quadbox");
}

/// The list without its first struct.
template <class First, class... Rest>
std::tuple<Rest...> without_first(const std::tuple<First, Rest...>&) {
  return {};
}

/// The list with its first two structs exchanged.
template <class A, class B, class... Rest>
std::tuple<B, A, Rest...> swapped(const std::tuple<A, B, Rest...>&) {
  return {};
}

/// A mode without a row.
struct Nameless {
  static constexpr const char* kName = "nameless";
};

TEST(Cullers, agree_with_the_table_only_in_number_order_and_name) {
  const AllCullers all;
  const auto rest = without_first(all);
  EXPECT_TRUE(agrees_with_table(all));
  EXPECT_FALSE(agrees_with_table(rest));
  EXPECT_FALSE(agrees_with_table(swapped(all)));
  EXPECT_FALSE(agrees_with_table(std::tuple_cat(all, std::tuple<Nameless>())));
  EXPECT_FALSE(agrees_with_table(std::tuple_cat(std::tuple<Nameless>(), rest)));
}

}  // namespace
}  // namespace qs
