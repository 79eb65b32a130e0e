// SPDX-License-Identifier: MIT
//
// Selections by neighbourhood and colour. Selections by other values are compared with an
// independent program in tests/io/edits/edits_file_test.cpp.
#include "raster/select/by_value.h"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "raster/kernel/constants.h"
#include "support/pool.h"
#include "support/scenes.h"

namespace qs::test {
namespace {

using testing::ElementsAre;

// Gaussians along x at these places, with a median size so that a cell is 1 long. A cell begins at
// the median place, so the other places are inside of cells. They are red
// below x = 100 and blue from there on.
GaussianCloud row_of(const std::vector<float>& places) {
  GaussianCloud cloud = random_cloud(places.size(), 0, 1);
  for (std::size_t i = 0; i < places.size(); ++i) {
    cloud.positions[i] = {places[i], 0, 0};
    cloud.log_scales[i] = glm::vec3(std::log(0.25f));
    const glm::vec3 color =
        places[i] < 100 ? glm::vec3(0.9f, 0.1f, 0.1f) : glm::vec3(0.1f, 0.1f, 0.9f);
    cloud.sh[i] = (color - 0.5f) / static_cast<float>(kSh0);
  }
  return cloud;
}

GaussianSet set_of(std::size_t size, std::initializer_list<std::size_t> numbers) {
  GaussianSet set(size);
  for (const std::size_t i : numbers) set.add(i);
  return set;
}

TEST(SelectedByValue, growing_adds_the_cells_next_to_the_set_and_shrinking_takes_them_away) {
  const GaussianCloud cloud = row_of({0, 1, 2, 3, 3.5f, 5, 20, 21});
  const GaussianSet all = GaussianSet(8).complement();
  const GaussianSet seed = set_of(8, {2});
  EXPECT_THAT(grown(cloud, seed, all, 1, pool()).numbers(), ElementsAre(1u, 2u, 3u));
  EXPECT_THAT(grown(cloud, seed, all, 2, pool()).numbers(), ElementsAre(0u, 1u, 2u, 3u, 4u));
  EXPECT_THAT(grown(cloud, seed, all, 100, pool()).numbers(), ElementsAre(0u, 1u, 2u, 3u, 4u, 5u));
  EXPECT_THAT(shrunk(cloud, set_of(8, {0, 1, 2, 3, 6, 7}), all, 1, pool()).numbers(),
              ElementsAre(0u, 1u, 2u, 6u, 7u));
  EXPECT_EQ(shrunk(cloud, all, all, 1, pool()), all);
  // Gaussians that are gone neither spread nor eat.
  GaussianSet rest = all;
  rest -= set_of(8, {3});
  EXPECT_THAT(grown(cloud, seed, rest, 100, pool()).numbers(), ElementsAre(0u, 1u, 2u));
  EXPECT_THAT(shrunk(cloud, set_of(8, {0, 1, 2}), rest, 1, pool()).numbers(),
              ElementsAre(0u, 1u, 2u));
  EXPECT_TRUE(grown(cloud, GaussianSet(8), all, 5, pool()).empty());
}

TEST(SelectedByValue, flooding_stays_in_the_colour_of_the_seed) {
  const GaussianCloud cloud = row_of({97, 97.5f, 99, 100, 101, 50, 51});
  const GaussianSet all = GaussianSet(7).complement();
  EXPECT_THAT(flooded(cloud, set_of(7, {0}), all, 10, pool()).numbers(), ElementsAre(0u, 1u, 2u));
  EXPECT_THAT(flooded(cloud, set_of(7, {4}), all, 10, pool()).numbers(), ElementsAre(3u, 4u));
  EXPECT_THAT(flooded(cloud, set_of(7, {0}), all, 500, pool()).numbers(),
              ElementsAre(0u, 1u, 2u, 3u, 4u));
  EXPECT_TRUE(flooded(cloud, GaussianSet(7), all, 500, pool()).empty());
}

TEST(SelectedByValue, lab_has_published_values) {
  // sRGB primaries and gray in CIELAB of D65, from the formulas of CIE 15 in single decimals.
  const std::pair<glm::dvec3, glm::dvec3> kColors[] = {{{1, 1, 1}, {100, 0, 0}},
                                                       {{0, 0, 0}, {0, 0, 0}},
                                                       {{1, 0, 0}, {53.24, 80.09, 67.20}},
                                                       {{0, 1, 0}, {87.73, -86.18, 83.18}},
                                                       {{0, 0, 1}, {32.30, 79.19, -107.86}},
                                                       {{7, -3, 0}, {53.24, 80.09, 67.20}}};
  for (const auto& [srgb, lab] : kColors) {
    const glm::dvec3 found = lab_of(srgb);
    for (int axis = 0; axis < 3; ++axis) EXPECT_NEAR(found[axis], lab[axis], 0.02);
  }
}

TEST(SelectedByValue, values_that_are_not_numbers_are_in_no_range) {
  GaussianCloud cloud = row_of({0, 1, 2});
  cloud.opacity_logits[0] = NAN;
  cloud.log_scales[0].y = NAN;
  cloud.sh[0].x = NAN;
  cloud.positions[0].z = NAN;
  cloud.log_scales[1] = glm::vec3(-INFINITY);
  cloud.opacity_logits[1] = INFINITY;
  const ValueRange any{-INFINITY, INFINITY};
  for (const GaussianSet& found :
       {gaussians_of_opacity(cloud, any, pool()), gaussians_of_size(cloud, any, pool()),
        gaussians_of_color(cloud, glm::dvec3(0.5), 1e9, pool()),
        gaussians_at_distance(cloud, glm::dvec3(0), {}, any, pool()),
        gaussians_at_distance(cloud, glm::dvec3(0), glm::dvec3(0, 0, 1), any, pool())})
    EXPECT_THAT(found.numbers(), ElementsAre(1u, 2u));
  EXPECT_THAT(gaussians_of_size(cloud, {0, 0.1}, pool()).numbers(), ElementsAre(1u));
}

}  // namespace
}  // namespace qs::test
