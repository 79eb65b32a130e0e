// SPDX-License-Identifier: MIT
// The inspector: pixels, Gaussians, and the uses of pairs.
#include <cmath>
#include <map>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "app/inspect/construction.h"
#include "app/inspect/inspection.h"
#include "base/error.h"
#include "support/inspector.h"

namespace qs {
namespace {

using testing::HasSubstr;

class Inspector : public test::InspectorTest {};

TEST_F(Inspector, a_pixel_s_contributions_add_up_to_its_color) {
  const Frame frame = render(default_mode());
  for (int y = 0; y < camera_.height; y += 7) {
    for (int x = 0; x < camera_.width; x += 7) {
      const PixelReport pixel = inspect_pixel(frame, {x, y}, settings_.background);
      for (int c = 0; c < 3; ++c)
        EXPECT_NEAR(pixel.color[c], frame.color.at(x, y, c), 2e-5f) << x << "," << y;
      float transmittance = 1, depth = 0;
      for (const Contribution& c : pixel.contributions) {
        EXPECT_FLOAT_EQ(c.transmittance, transmittance);
        EXPECT_FLOAT_EQ(c.weight, c.alpha * c.transmittance);
        EXPECT_GE(c.alpha, kAlphaMin);
        EXPECT_GE(c.depth, depth);
        transmittance *= 1 - c.alpha;
        depth = c.depth;
      }
      EXPECT_FLOAT_EQ(pixel.transmittance, transmittance);
      if (pixel.stopped_by) {
        EXPECT_LT(transmittance * (1 - pixel.stopped_by->alpha), kTransmittanceMin);
        EXPECT_EQ(pixel.evaluated,
                  frame.evaluated[static_cast<std::size_t>(y * camera_.width + x)]);
      }
    }
  }
}

TEST_F(Inspector, counts_of_all_visible_gaussians_are_the_renderer_s_pairs_in_every_mode) {
  for (const int tile_px : kTileSizes) {
    for (CullMode mode = 1; mode <= culler_count(); ++mode) {
      const Frame frame = render(mode, tile_px);
      std::uint64_t pairs = 0;
      for (std::size_t slot = 0; slot < frame.trace.gaussians.size(); ++slot) {
        const ModeTiles tiles = mode_tiles(mode, frame.trace.footprints[slot], frame.grid);
        EXPECT_EQ(tiles.tiles.size(),
                  count_mode_tiles(mode, frame.trace.footprints[slot], frame.grid));
        pairs += tiles.tiles.size();
      }
      EXPECT_EQ(pairs, frame.stats.tile_pairs) << mode_name(mode) << " " << tile_px;
    }
  }
}

TEST_F(Inspector, a_gaussian_s_tiles_are_those_whose_lists_hold_it) {
  for (CullMode mode = 1; mode <= culler_count(); ++mode) {
    const Frame frame = render(mode);
    std::map<std::uint32_t, std::vector<int>> listed;
    for (int tile = 0; tile < frame.grid.count(); ++tile) {
      for (const std::uint32_t gaussian : list_of(frame.trace, tile))
        listed[gaussian].push_back(tile);
    }
    for (std::size_t slot = 0; slot < frame.trace.gaussians.size(); slot += 5) {
      const GaussianReport report = inspect_gaussian(frame.trace, slot, frame.grid);
      std::vector<int> tiles = report.modes[static_cast<std::size_t>(mode - 1)].tiles;
      std::sort(tiles.begin(), tiles.end());
      EXPECT_EQ(tiles, listed[report.gaussian]) << mode_name(mode);
    }
  }
}

TEST_F(Inspector, a_slot_is_found_for_every_visible_gaussian_and_for_no_other) {
  const Trace trace = render(default_mode()).trace;
  const std::vector<std::uint32_t> slots = slots_of(trace, cloud_.size());
  std::size_t visible = 0;
  for (std::uint32_t gaussian = 0; gaussian < cloud_.size() + 5; ++gaussian) {
    const std::optional<std::size_t> slot = slot_of(trace, gaussian);
    if (gaussian < cloud_.size()) {
      ASSERT_EQ(slots[gaussian], slot.value_or(0xffffffff));
    }
    if (!slot) continue;
    ASSERT_EQ(trace.gaussians.at(*slot), gaussian);
    ++visible;
  }
  EXPECT_EQ(visible, trace.gaussians.size());
  EXPECT_LT(visible, cloud_.size());
}

TEST_F(Inspector, shape_facts_agree_with_each_other) {
  const Frame frame = render(find_culler("adr"));
  for (std::size_t slot = 0; slot < frame.trace.gaussians.size(); ++slot) {
    const GaussianReport g = inspect_gaussian(frame.trace, slot, frame.grid);
    ASSERT_TRUE(g.visible);
    const glm::vec3 q = g.footprint.conic;
    const auto level = [&](glm::vec2 at) {
      const glm::dvec2 d = glm::dvec2(at) - glm::dvec2(g.footprint.mean_px);
      return static_cast<double>(q.x) * d.x * d.x + 2 * static_cast<double>(q.y) * d.x * d.y +
             static_cast<double>(q.z) * d.y * d.y;
    };
    if (g.anisotropy > 50) continue;  // the single-precision conic no longer describes the ellipse
    glm::vec2 low(1e9f), high(-1e9f);
    for (const glm::vec2 point : ellipse_of(g.footprint, 720)) {
      EXPECT_NEAR(level(point) / static_cast<double>(g.footprint.gamma), 1, 2e-2);
      low = glm::min(low, point);
      high = glm::max(high, point);
    }
    const float reach = glm::length(g.adr.high - g.adr.low);
    EXPECT_NEAR(low.x, g.adr.low.x, 1e-3f * reach + 1e-2f);
    EXPECT_NEAR(high.y, g.adr.high.y, 1e-3f * reach + 1e-2f);
    EXPECT_NEAR(g.half_axes.x / g.half_axes.y, g.anisotropy, 1e-3f * g.anisotropy);
    EXPECT_LE(std::abs(g.tilt), 1.5708f);
    ASSERT_EQ(g.quad_boxes.size(), 4u);
    ASSERT_EQ(g.dual_boxes.size(), 2u);
    // The ellipse leans into the quadrants that dualbox keeps.
    const bool leans_same = g.footprint.covariance.xy > 0;
    EXPECT_EQ(
        g.dual_boxes[0].low == g.quad_boxes[0].low && g.dual_boxes[1].high == g.quad_boxes[3].high,
        leans_same);
  }
}

TEST_F(Inspector, qpass_walks_the_shorter_axis_and_its_intervals_are_the_tiles) {
  const Frame frame = render(default_mode());
  for (std::size_t slot = 0; slot < frame.trace.gaussians.size(); ++slot) {
    const ModeTiles quad = mode_tiles(default_mode(), frame.trace.footprints[slot], frame.grid);
    std::vector<int> tiles;
    int line = -1;
    for (const TileRun& run : quad.runs) {
      EXPECT_GT(run.line, line);
      line = run.line;
      for (int tile = run.tiles.begin; tile < run.tiles.end; ++tile) {
        tiles.push_back(quad.walks_rows ? run.line * frame.grid.columns + tile
                                        : tile * frame.grid.columns + run.line);
      }
    }
    EXPECT_EQ(tiles, quad.tiles);
  }
  EXPECT_TRUE(
      mode_tiles(find_culler("quadbox-naive"), frame.trace.footprints[0], frame.grid).runs.empty());
}

TEST_F(Inspector, pair_uses_are_the_renderer_s_used_pairs) {
  for (const int tile_px : kTileSizes) {
    for (CullMode mode = 1; mode <= culler_count(); ++mode) {
      const Frame frame = render(mode, tile_px);
      const std::vector<PairUse> uses = pair_uses(frame, size(), pool_);
      const PairUses sums = sum_up(uses);
      EXPECT_EQ(sums.pairs(), frame.stats.tile_pairs);
      EXPECT_EQ(sums.used, *frame.stats.used_pairs) << mode_name(mode) << " " << tile_px;
      EXPECT_GT(sums.hidden, 0u);
    }
  }
}

TEST_F(Inspector, use_in_a_tile_equals_that_of_the_whole_frame) {
  const Frame frame = render(find_culler("3dgs"));
  const std::vector<PairUse> uses = pair_uses(frame, size(), pool_);
  for (int tile = 0; tile < frame.grid.count(); tile += 3) {
    const std::uint64_t begin = frame.trace.tile_begin[static_cast<std::size_t>(tile)];
    const auto list = list_of(frame.trace, tile);
    for (std::size_t k = 0; k < list.size(); k += 11)
      EXPECT_EQ(use_in_tile(frame, size(), *slot_of(frame.trace, list[k]), tile), uses[begin + k]);
  }
}

TEST_F(Inspector, exact_has_the_fewest_false_positives_of_the_lossless_modes) {
  std::map<std::string, PairUses> sums;
  for (CullMode mode = 1; mode <= culler_count(); ++mode)
    sums[mode_name(mode)] = sum_up(pair_uses(render(mode), size(), pool_));
  for (const char* name : {"3dgs", "adr", "quadbox", "quadbox-naive"})
    EXPECT_LT(sums["exact"].false_positives(), sums[name].false_positives()) << name;
  // Hidden pairs do not depend on the bound.
  EXPECT_EQ(sums["exact"].hidden, sums["quadbox"].hidden);
  EXPECT_GT(sums["exact"].hidden, 0u);
  EXPECT_LT(sums["exact"].empty, sums["quadbox"].empty / 2);
}

TEST_F(Inspector, picks_the_heaviest_gaussian_unless_another_is_given) {
  const Frame frame = render(default_mode());
  const glm::ivec2 middle = size() / 2;
  const Inspection inspection = inspect(frame, size(), middle, settings_.background);
  ASSERT_TRUE(inspection.gaussian.has_value());
  float picked = 0, most = 0;
  for (const Contribution& c : inspection.pixel.contributions) {
    if (c.gaussian == inspection.gaussian->gaussian) picked = c.weight;
    most = std::max(most, c.weight);
  }
  EXPECT_EQ(picked, most);
  ASSERT_EQ(inspection.uses.size(), inspection.gaussian->modes.size());
  const std::uint32_t other = frame.trace.gaussians.front();
  EXPECT_EQ(inspect(frame, size(), middle, {}, other).gaussian->gaussian, other);
  EXPECT_THROW(inspect(frame, size(), {200, 0}, {}), Error);
  EXPECT_THROW(inspect(frame, size(), middle, {}, 999999), Error);
}

TEST_F(Inspector, json_has_the_numbers_of_the_text) {
  const Frame frame = render(default_mode());
  const Inspection inspection = inspect(frame, size(), size() / 2, settings_.background);
  const nlohmann::ordered_json json = inspection_json(inspection);
  EXPECT_EQ(json["contributions"].size(), inspection.pixel.contributions.size());
  const std::string text = format_inspection(inspection);
  EXPECT_THAT(text, HasSubstr("Gaussian " + std::to_string(inspection.gaussian->gaussian)));
  ASSERT_EQ(json["picked"]["modes"].size(), static_cast<std::size_t>(culler_count()));
  for (std::size_t i = 0; i < static_cast<std::size_t>(culler_count()); ++i) {
    const auto& mode = json["picked"]["modes"][i];
    EXPECT_EQ(mode["count"], mode["tiles"].size());
    EXPECT_EQ(mode["count"].get<int>(),
              mode["used"].get<int>() + mode["hidden"].get<int>() + mode["empty"].get<int>());
    EXPECT_THAT(text, HasSubstr(mode["mode"].get<std::string>()));
  }
}

TEST_F(Inspector, draws_the_construction_of_any_gaussian) {
  const Frame frame = render(find_culler("3dgs"));
  for (std::size_t slot = 0; slot < frame.trace.gaussians.size();
       slot += frame.trace.gaussians.size() / 5) {
    const Inspection inspection = inspect(frame, size(), {3, 5}, {}, frame.trace.gaussians[slot]);
    const Image page = draw_construction({inspection, frame.color, frame.grid, "a scene"});
    EXPECT_EQ(page.width, 1800);
    const auto [low, high] = std::minmax_element(page.values.begin(), page.values.end());
    EXPECT_LT(*low, 0.2f);
    EXPECT_FLOAT_EQ(*high, 1);
  }
}

}  // namespace
}  // namespace qs
