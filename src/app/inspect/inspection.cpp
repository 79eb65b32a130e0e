// SPDX-License-Identifier: MIT
#include "app/inspect/inspection.h"

#include <algorithm>
#include <cmath>
#include <map>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "base/fail.h"
#include "base/json_of.h"
#include "base/list_of.h"
#include "base/text.h"

namespace qs {
namespace {

std::optional<std::uint32_t> heaviest(const PixelReport& pixel) {
  const auto& all = pixel.contributions;
  const auto best = std::ranges::max_element(all, {}, &Contribution::weight);
  if (best == all.end()) return std::nullopt;
  return best->gaussian;
}

using nlohmann::ordered_json;
using qs::json_of;  // for vectors

ordered_json json_of(const Box& box) {
  return {{"low", json_of(box.low)}, {"high", json_of(box.high)}};
}
ordered_json json_of(const std::vector<Box>& boxes) {
  return list_of<ordered_json>(boxes, [](const Box& box) { return json_of(box); });
}

ordered_json json_of(const Contribution& c) {
  return {{"gaussian", c.gaussian},           {"depth", c.depth},   {"alpha", c.alpha},
          {"transmittance", c.transmittance}, {"weight", c.weight}, {"color", json_of(c.color)}};
}

ordered_json json_of(const ModeTiles& mode, const std::vector<PairUse>& uses) {
  const PairUses sums = sum_up(uses);
  ordered_json json = {
      {"mode", mode_name(mode.mode)}, {"count", mode.tiles.size()}, {"used", sums.used},
      {"hidden", sums.hidden},        {"empty", sums.empty},        {"tiles", mode.tiles}};
  if (mode.runs.empty()) return json;
  json["walks"] = mode.walks_rows ? "rows" : "columns";
  for (const TileRun& run : mode.runs)
    json["lines"].push_back(
        {{"line", run.line}, {"begin", run.tiles.begin}, {"end", run.tiles.end}});
  return json;
}

ordered_json json_of(const GaussianReport& g, const std::vector<std::vector<PairUse>>& uses) {
  const Covariance2<float>& s = g.footprint.covariance;
  ordered_json json = {{"gaussian", g.gaussian},
                       {"depth", g.depth},
                       {"opacity", g.opacity},
                       {"color", json_of(g.color)},
                       {"mean", json_of(g.footprint.mean_px)},
                       {"covariance", {s.xx, s.xy, s.yy}},
                       {"conic", json_of(g.footprint.conic)},
                       {"gamma", g.footprint.gamma},
                       {"f", g.f},
                       {"half_axes", json_of(g.half_axes)},
                       {"anisotropy", g.anisotropy},
                       {"tilt", g.tilt},
                       {"square", json_of(g.square)},
                       {"adr", json_of(g.adr)},
                       {"dual_boxes", json_of(g.dual_boxes)},
                       {"quad_boxes", json_of(g.quad_boxes)},
                       {"modes", ordered_json::array()}};
  for (std::size_t i = 0; i < g.modes.size(); ++i)
    json["modes"].push_back(json_of(g.modes[i], uses[i]));
  return json;
}

std::string line_of(const Contribution& c, const char* remark) {
  return fmt::format("{:>9}  {:>10.4f}  {:>7.4f}  {:>13.4f}  {:>7.4f}  {:.3f} {:.3f} {:.3f}{}\n",
                     c.gaussian, c.depth, c.alpha, c.transmittance, c.weight, c.color.x, c.color.y,
                     c.color.z, remark);
}

/// The lines of a table's entries; of many, the first, and a line with the number of the others.
template <class Entries, class LineOf>
std::string lines_of(const Entries& entries, const char* indent, const LineOf& line) {
  constexpr std::size_t kLines = 40;
  std::string text;
  for (const auto& entry : std::span(entries).first(std::min(entries.size(), kLines)))
    text += line(entry);
  if (entries.size() > kLines)
    text += fmt::format("{}... {} more, see --json\n", indent, entries.size() - kLines);
  return text;
}

std::string pixel_table(const PixelReport& pixel) {
  std::string text = fmt::format(
      "pixel {},{} in tile {}: {} Gaussians are listed, {} evaluated, {} blended\n"
      "{:>9}  {:>10}  {:>7}  {:>13}  {:>7}  colour\n",
      pixel.pixel.x, pixel.pixel.y, pixel.tile, grouped(pixel.listed), grouped(pixel.evaluated),
      pixel.contributions.size(), "gaussian", "depth", "alpha", "transmittance", "weight");
  text += lines_of(pixel.contributions, "      ",
                   [](const Contribution& each) { return line_of(each, ""); });
  if (pixel.stopped_by) text += line_of(*pixel.stopped_by, "  <- stops the pixel");
  return text + fmt::format("colour {:.4f} {:.4f} {:.4f}, {:.5f} of the background is visible\n",
                            pixel.color.x, pixel.color.y, pixel.color.z, pixel.transmittance);
}

std::string walk_lines(const ModeTiles& mode) {
  const auto line = [&](const TileRun& run) {
    return fmt::format("  {} {}: {} {} to {} ({} tiles)\n", mode.walks_rows ? "row" : "column",
                       run.line, mode.walks_rows ? "columns" : "rows", run.tiles.begin,
                       run.tiles.end - 1, run.tiles.size());
  };
  return fmt::format("{} walks {}:\n{}", mode_name(mode.mode),
                     mode.walks_rows ? "rows of tiles" : "columns of tiles",
                     lines_of(mode.runs, "  ", line));
}

}  // namespace

Outputs inspection_outputs() { return {.trace = true}; }

Inspection inspect(const Frame& frame, glm::ivec2 size, glm::ivec2 pixel, glm::vec3 background,
                   std::optional<std::uint32_t> gaussian) {
  if (pixel.x < 0 || pixel.y < 0 || pixel.x >= size.x || pixel.y >= size.y)
    fail(ErrorKind::usage, "inspect: there is no pixel {},{}: the picture is {} x {}", pixel.x,
         pixel.y, size.x, size.y);
  Inspection result;
  result.pixel = inspect_pixel(frame, pixel, background);
  const std::optional<std::uint32_t> picked = gaussian ? gaussian : heaviest(result.pixel);
  if (!picked) return result;
  const std::optional<std::size_t> slot = slot_of(frame.trace, *picked);
  if (!slot)
    fail(ErrorKind::usage,
         "inspect: Gaussian {} is not visible in this view and mode, in which {} of the scene's "
         "{} Gaussians are",
         *picked, frame.stats.visible, frame.stats.gaussians);
  result.gaussian = inspect_gaussian(frame.trace, *slot, frame.grid);
  std::map<int, PairUse> known;  // modes share most of their tiles
  for (const ModeTiles& mode : result.gaussian->modes) {
    std::vector<PairUse>& uses = result.uses.emplace_back();
    for (const int tile : mode.tiles) {
      const auto [at, is_new] = known.try_emplace(tile, PairUse::empty);
      if (is_new) at->second = use_in_tile(frame, size, *slot, tile);
      uses.push_back(at->second);
    }
  }
  return result;
}

PairUses uses_of(const Inspection& inspection, std::size_t mode_index) {
  return sum_up(inspection.uses[mode_index]);
}

std::vector<InspectedFact> gaussian_facts(const GaussianReport& g) {
  const glm::vec3 q = g.footprint.conic;
  const glm::vec2 mean = g.footprint.mean_px;
  std::vector<InspectedFact> facts = {
      {"mean", fmt::format("{:.2f}, {:.2f} px", mean.x, mean.y)},
      {"depth", fmt::format("{:.4f}", g.depth)},
      {"opacity", fmt::format("{:.4f}", g.opacity)},
      {"conic a, b, c", fmt::format("{:.5f}, {:.5f}, {:.5f}", q.x, q.y, q.z)},
      {"gamma", fmt::format("{:.3f}", g.footprint.gamma)}};
  if (g.visible) {
    facts.push_back({"half axes", fmt::format("{:.2f}, {:.2f} px", g.half_axes.x, g.half_axes.y)});
    facts.push_back({"stretch f", fmt::format("{:.4f}", g.f)});
  }
  facts.push_back({"anisotropy", fmt::format("{:.2f}", g.anisotropy)});
  facts.push_back({"tilt", fmt::format("{:.1f}\u00b0", static_cast<double>(g.tilt) * 180 / M_PI)});
  return facts;
}

std::string format_inspection(const Inspection& inspection) {
  std::string text = pixel_table(inspection.pixel);
  if (!inspection.gaussian) return text;
  const GaussianReport& g = *inspection.gaussian;
  text += fmt::format("\nGaussian {}\n", g.gaussian);
  for (const InspectedFact& fact : gaussian_facts(g))
    text += fmt::format("  {:14}{}\n", fact.label, fact.value);
  text += fmt::format("\n{:14}{:>8}{:>8}{:>8}{:>8}\n", "mode", "tiles", "used", "hidden", "empty");
  for (std::size_t i = 0; i < g.modes.size(); ++i) {
    const PairUses uses = uses_of(inspection, i);
    text += fmt::format("{:14}{:>8}{:>8}{:>8}{:>8}\n", mode_name(g.modes[i].mode), uses.pairs(),
                        uses.used, uses.hidden, uses.empty);
  }
  text +=
      "used: a pixel blends it; hidden: it reaches only stopped pixels; empty: it reaches no "
      "pixel\n";
  for (const ModeTiles& mode : g.modes) {
    if (mode.mode != kQuad || mode.runs.empty()) continue;
    text += '\n' + walk_lines(mode);
  }
  return text;
}

ordered_json inspection_json(const Inspection& inspection) {
  const PixelReport& p = inspection.pixel;
  ordered_json json = {{"pixel", {p.pixel.x, p.pixel.y}},
                       {"tile", p.tile},
                       {"listed", p.listed},
                       {"evaluated", p.evaluated},
                       {"transmittance", p.transmittance},
                       {"color", json_of(p.color)},
                       {"contributions", ordered_json::array()},
                       {"stopped_by", nullptr},
                       {"picked", nullptr}};
  for (const Contribution& c : p.contributions) json["contributions"].push_back(json_of(c));
  if (p.stopped_by) json["stopped_by"] = json_of(*p.stopped_by);
  if (inspection.gaussian) json["picked"] = json_of(*inspection.gaussian, inspection.uses);
  return json;
}

}  // namespace qs
