// SPDX-License-Identifier: MIT
// The test vectors for ports of the culling modes: every mode passes them, and each usual bug of a
// port is caught by the vector that docs/check_your_port.md names.
#include "support/cull_vectors.h"

#include <fstream>
#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "raster/kernel/cull/mode.h"
#include "raster/kernel/cull/modes.h"
#include "support/cull_port.h"
#include "support/shared.h"

namespace qs {
namespace {

using test::CullVector;
using test::PortBug;
using testing::HasSubstr;

const test::CullVectors& vectors() {
  static const test::CullVectors read = test::read_cull_vectors();
  return read;
}

template <class P>
std::set<int> vector_tiles(const CullVector& vector) {
  std::set<int> tiles;
  if (!(vector.footprint.gamma > 0) && !row_of<P>().keeps_faint) return tiles;
  for_each_tile<P>(vector.footprint, vector.grid, [&](int tile) { tiles.insert(tile); });
  return tiles;
}

TEST(CullVectors, are_a_few_hundred_of_every_kind) {
  EXPECT_GE(vectors().all.size(), 300u);
  std::set<std::string> names;
  for (const CullVector& vector : vectors().all) names.insert(vector.name);
  EXPECT_EQ(names.size(), vectors().all.size());
  for (const char* kind : {"round", "needle", "axis", "huge", "tiny", "off-screen", "border",
                           "faint", "last-tile", "first-tile", "threshold"})
    EXPECT_TRUE(names.contains(std::string(kind) + "-10")) << kind;
}

TEST(CullVectors, leave_little_to_rounding) {
  std::size_t must = 0, may = 0;
  for (const CullVector& vector : vectors().all) {
    for (const auto& [name, map] : vector.maps) {
      must += map.must.size();
      may += map.may.size();
    }
  }
  EXPECT_LT(may * 200, must);
}

TEST(CullVectors, are_passed_by_every_mode) {
  for (CullMode mode = 1; mode <= mode_count(); ++mode) {
    with_culler(mode, [&]<class P>(P) {
      ASSERT_TRUE(vectors().map_of_mode.contains(P::kName)) << P::kName;
      for (const CullVector& vector : vectors().all) {
        const std::set<int> listed = vector_tiles<P>(vector);
        EXPECT_EQ(vector.maps.at(vectors().map_of_mode.at(P::kName)).fault_of(listed), "")
            << P::kName << " " << vector.name;
        if (!row_of<P>().lossless) continue;
        for (const int tile : vector.maps.at("needed").must)
          EXPECT_TRUE(listed.contains(tile)) << P::kName << " " << vector.name << " tile " << tile;
      }
    });
  }
}

/// A row of the table of bugs in the documentation.
struct Row {
  PortBug bug;
  const char* words;   ///< the text in the documentation
  const char* mode;    ///< in which the bug is visible
  const char* vector;  ///< that detects the bug
};

constexpr Row kRows[] = {
    {PortBug::half_pixel, "pixel centres at i + 1/2 instead of i", "adr", "border-07"},
    {PortBug::larger_radius, "a box from the larger eigenvalue, rounded up, on both axes", "adr",
     "needle-01"},
    {PortBug::three_sigma, "3 sigma instead of the opacity's ellipse", "adr", "faint-01"},
    {PortBug::faint_kept, "opacity below 1/255 is not dropped", "adr", "threshold-01"},
    {PortBug::no_factor_two, "gamma = ln(255 opacity), without the factor 2", "adr", "round-01"},
    {PortBug::last_tile, "the end of a run is floor(high / 16) instead of ceil", "adr", "tiny-01"},
    {PortBug::partial_tile, "a last tile that the picture cuts is left out", "adr", "last-tile-01"},
    {PortBug::truncated, "truncation instead of floor and ceil for negative coordinates", "adr",
     "first-tile-01"},
    {PortBug::swapped_conic, "x and y swapped in the conic (a and c exchanged)", "adr", "axis-01"},
    {PortBug::wrong_sign, "the wrong sign of b chooses the major quadrants", "quadbox",
     "needle-01"},
    {PortBug::no_root_of_f, "the minor boxes scaled by f^2 instead of f", "quadbox", "needle-29"},
    {PortBug::single_b, "b x y instead of 2 b x y in the quadratic form", "exact", "round-01"},
    {PortBug::corners_only, "only the four corners of a tile are tested", "exact", "needle-01"},
    {PortBug::borders, "the borders of a tile instead of its pixel centres", "exact", "border-10"},
    {PortBug::columns_first, "tile index = column * rows + row", "adr", "off-screen-07"},
    {PortBug::dilated_twice, "0.3 added to the variances once more", "exact", "tiny-23"},
    {PortBug::square_not_ceiled, "the radius of 3dgs is not rounded up", "3dgs", "tiny-03"},
};

bool catches(const CullVector& vector, const std::string& mode, PortBug bug) {
  const test::TileMap& map = vector.maps.at(vectors().map_of_mode.at(mode));
  return !map.fault_of(test::tiles_of_port(mode, vector, bug)).empty();
}

TEST(CullPort, without_a_bug_passes_all_vectors) {
  for (const char* mode : {"3dgs", "adr", "dualbox", "quadbox", "exact"}) {
    for (const CullVector& vector : vectors().all)
      EXPECT_FALSE(catches(vector, mode, PortBug::none)) << mode << " " << vector.name;
  }
}

TEST(CullPort, with_a_usual_bug_fails_the_vector_that_the_documentation_names) {
  std::stringstream text;
  text << std::ifstream(test::source_path("docs/check_your_port.md")).rdbuf();
  for (const Row& row : kRows) {
    EXPECT_TRUE(catches(vectors().named(row.vector), row.mode, row.bug)) << row.words;
    std::ostringstream others;
    for (const CullVector& vector : vectors().all)
      if (catches(vector, row.mode, row.bug)) others << " " << vector.name;
    SCOPED_TRACE("caught by" + others.str());
    EXPECT_THAT(text.str(), HasSubstr(std::string("| ") + row.words + " | `" + row.mode + "` | `" +
                                      row.vector + "` |"));
  }
  EXPECT_EQ(std::size(kRows), static_cast<std::size_t>(PortBug::square_not_ceiled))
      << "a bug has no row";
}

}  // namespace
}  // namespace qs
