// SPDX-License-Identifier: MIT
#include "app/viewer/state/panel_text.h"

#include <algorithm>
#include <memory>
#include <vector>

#include <fmt/format.h>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>

#include "app/framing/camera_control.h"
#include "app/framing/scene_box.h"
#include "app/inspect/heatmap_frame.h"
#include "app/measure/scene_facts.h"
#include "app/viewer/state/samples.h"
#include "base/text.h"
#include "io/camera/lens_views.h"

namespace qs {
namespace {

// Where each letter begins, and the end of the text.
std::vector<std::size_t> begins_of(const std::string& text) {
  std::vector<std::size_t> begins;
  for (std::size_t i = 0; i < text.size(); ++i)
    if ((static_cast<unsigned char>(text[i]) & 0xc0) != 0x80) begins.push_back(i);
  begins.push_back(text.size());
  return begins;
}

// For a split window with heat maps: the names of both sides with the totals of their maps.
std::string totals_of_split(const Viewer& viewer) {
  const ShownFrame& shown = viewer.shown;
  const std::array<std::string, 2> names = split_names(viewer);
  std::array<std::uint64_t, 2> totals = {shown.heatmap->total, shown.other->heatmap->total};
  if (viewer.split.flipped) std::swap(totals[0], totals[1]);
  return fmt::format("{} {} \u00b7 {} {} in all", names[0], grouped(totals[0]), names[1],
                     counted(totals[1], heatmap_row(shown.heatmap->quantity).unit));
}

}  // namespace

std::string scene_summary(const Viewer& viewer) {
  const ViewedScene& scene = *viewer.scene;
  return fmt::format(
      "{}   {}   {}   {} x {}", scene.name,
      scene.nodes > 0 ? counted(scene.nodes, "node") : counted(scene.gaussians, "Gaussian"),
      kBackendNames[static_cast<int>(viewer.backend)], viewer.camera.width, viewer.camera.height);
}

RenderSettings shown_settings(const Viewer& viewer) {
  RenderSettings settings = viewer.settings;
  settings.mode = viewer.mode();
  const bool has_maps =
      viewer.heatmap == HeatQuantity::missed || viewer.panels.split || viewer.shows_grid;
  if (settings.lens && settings.lens->is_parallel()) {
    const double distance = glm::length(viewer.pivot - viewer.camera.position());
    settings.lens = std::make_shared<const LensView>(
        parallel_view(viewer.camera.height * distance / viewer.camera.focal_px.y));
  } else if (has_maps) {
    settings.lens.reset();
  }
  return settings;
}

Alterations alterations_of(const Viewer& viewer) {
  if (!viewer.scene) return {};
  const ViewedScene& scene = *viewer.scene;
  return alterations_of(shown_settings(viewer),
                        {scene.sh_degree, scene.antialiased, scene.white_background,
                         scene.axes.empty() ? scene.declared_axes : scene.axes, scene.declared_axes,
                         scene.edits, "", viewer.levels.has_value()});
}

std::vector<Fact> scene_facts_of(const Viewer& viewer) {
  const ViewedScene& scene = *viewer.scene;
  const glm::dvec3 at = viewer.camera.position();
  std::vector<Fact> facts = {
      {"file", scene.path.string()},
      {"format", scene.format},
      {scene.nodes > 0 ? "nodes" : "Gaussians",
       grouped(scene.nodes > 0 ? scene.nodes : scene.gaussians)},
      {"size", bytes_text(scene.file_bytes)},
      {"SH degree",
       fmt::format("{}{}", scene.sh_degree, scene.antialiased ? ", trained antialiased" : "")},
      {"extent", fmt::format("{:.3g} units, the longest side of its middle 90 %", scene.extent())},
      {"cameras", scene.cameras.empty()
                      ? std::string("none: drop a cameras.json on the window")
                      : fmt::format("{}, {} with a photograph", scene.cameras.size(),
                                    scene.photographs.size())},
      {"view", fmt::format("from {:.3g}, {:.3g}, {:.3g}", at.x, at.y, at.z)},
      {"lens", fmt::format("{:.1f} degrees, near plane {:.3g}",
                           glm::degrees(vertical_fov(viewer.camera)), viewer.camera.near_depth)},
  };
  if (viewer.levels) facts.push_back({"levels", viewer.levels->text()});
  if (scene.huge > 0) facts.push_back({"too large", huge_text(scene.huge)});
  if (scene.skipped_huge > 0)
    facts.push_back({"too large", huge_text(scene.skipped_huge) + ": left out"});
  if (viewer.is_remote) facts.erase(facts.begin());  // the path is of this machine
  return facts;
}

std::string camera_label(const ViewedScene& scene, std::size_t index) {
  const Camera& camera = scene.cameras[index];
  return fmt::format("{}  {}  {} x {}{}", index, camera.name, camera.width, camera.height,
                     scene.photographs.count(static_cast<int>(index)) > 0 ? "  photograph" : "");
}

std::string keyframe_label(const Viewer& viewer, std::size_t index) {
  return fmt::format("{}  at {:.2f} s", index + 1, viewer.keyframes[index].time);
}

std::array<std::string, 4> contribution_cells(const Contribution& row, bool stops) {
  return {fmt::format("{:.3f}", row.depth), fmt::format("{:.4f}", row.alpha),
          fmt::format("{:.4f}", row.transmittance),
          stops ? "-" : fmt::format("{:.4f}", row.weight)};
}

std::string inspected_pixel_text(const PixelReport& pixel) {
  return fmt::format("Pixel {}, {}: {} of the {} of its tile {} blended", pixel.pixel.x,
                     pixel.pixel.y, grouped(pixel.contributions.size()),
                     counted(pixel.listed, "Gaussian"),
                     pixel.contributions.size() == 1 ? "is" : "are");
}

std::optional<HeatQuantity> awaited_map(const Viewer& viewer) {
  const std::optional<Heatmap>& shown = viewer.shown.heatmap;
  const bool draws = viewer.scene && !viewer.zoom.running;
  if (!draws || !viewer.heatmap || (shown && shown->quantity == *viewer.heatmap))
    return std::nullopt;
  return viewer.heatmap;
}

std::string awaited_title(const Viewer& viewer) {
  Heatmap none;
  none.cell_px = viewer.settings.tile_px;
  const std::optional<HeatQuantity> awaited = awaited_map(viewer);
  none.quantity = awaited.value_or(none.quantity);
  return awaited ? make_legend(none, Scale(), "").title : "";
}

Legend heat_legend(const Viewer& viewer) {
  const ShownFrame& shown = viewer.shown;
  Legend legend = make_legend(*shown.heatmap, shown.map_scale, mode_name(shown.mode),
                              viewer.heat_view.style.colors);
  legend.title += size_text(shown.divisor);
  legend.facts = heat_facts(viewer) + " \u00b7 " + scale_text(viewer);
  return legend;
}

CullMode mode_of_scale(const Viewer& viewer) {
  return scale_mode(viewer.shown.heatmap->quantity, viewer.baseline);
}

std::string scale_text(const Viewer& viewer) {
  if (viewer.heat_view.maximum > 0) return "fixed scale";
  if (viewer.shown.scale_version != viewer.shown.view_version) return "scale of an earlier view";
  return fmt::format("scale of {}", mode_name(mode_of_scale(viewer)));
}

const Heatmap& heatmap_at(const Viewer& viewer, glm::dvec2 pixel) {
  const ShownFrame& shown = viewer.shown;
  if (!shown.other || !shown.other->heatmap) return *shown.heatmap;
  const Split& split = viewer.split;
  const bool right = split.view == SplitView::sides &&
                     pixel.x >= static_cast<double>(split.divider) * viewer.camera.width;
  return right != split.flipped ? *shown.other->heatmap : *shown.heatmap;
}

std::string heat_facts(const Viewer& viewer) {
  const ShownFrame& shown = viewer.shown;
  const char* mode = mode_name(shown.mode);
  if (shown.grid) return "the same scale for all modes";
  if (shown.other && shown.other->heatmap) return totals_of_split(viewer);
  return shown.missed ? fmt::format("mode {} \u00b7 {}", mode, missed_sentence(*shown.missed))
                      : make_legend(*shown.heatmap, shown.map_scale, mode).facts;
}

std::string heat_text(const ShownFrame& shown, const Heatmap& map, std::size_t cell) {
  std::string text = "here: " + counted(map.values[cell], heatmap_row(map.quantity).unit) +
                     size_text(shown.divisor);
  if (shown.missed && &map == &*shown.heatmap && map.values[cell] > 0)
    text += fmt::format(", alpha to {:.2f}, colour off by {:.3f}", shown.missed->alphas[cell],
                        shown.missed->errors[cell]);
  return text;
}

std::string value_text(const ShownFrame& shown, std::size_t pixel) {
  const ValueMap& map = *shown.values;
  const float value = map.values[pixel];
  if (!(value > 0)) return "here: nothing";
  return fmt::format("here: {:.4g}{}", value, row_of(map.quantity).unit);
}

std::array<std::string, 2> names_of_scenes(const Viewer& viewer, const SceneBeside& beside) {
  const std::filesystem::path& first = viewer.scene->path;
  const std::array<std::string, 2> names = {scene_name(first), scene_name(beside.path)};
  if (viewer.levels && first == beside.path)
    return {names[0] + ", levels of detail", names[1] + ", all leaves"};
  if (names[0] != names[1]) return names;
  return {first.string(), beside.path.string()};
}

std::array<std::string, 2> split_names(const Viewer& viewer) {
  const Variant first{viewer.shown.mode, viewer.shown.stats.pipeline, viewer.backend};
  const ShownOther& other = *viewer.shown.other;
  const Variant& second = other.variant;
  std::array<std::string, 2> names = {name_beside(first, second), name_beside(second, first)};
  if (other.scene) names = names_of_scenes(viewer, *other.scene);
  if (viewer.split.flipped) std::swap(names[0], names[1]);
  return names;
}

Legend pair_legend(const ShownFrame& shown) {
  const std::string end = grouped(shown.other->pairs_scale.maximum);
  return {.title = "Tile pairs of the first minus the second",
          .ticks = {{0, "\u2212" + end}, {0.5f, "0"}, {1, "+" + end + " pairs in a tile"}},
          .color = [](float t) { return diverging(2 * t - 1); }};
}

int shown_amplification(const Viewer& viewer) {
  if (viewer.split.amplification > 0) return viewer.split.amplification;
  return viewer.shown.other ? visible_amplification(viewer.shown.other->pixels) : 1;
}

Split shown_split(const Viewer& viewer) {
  Split split = viewer.split;
  split.amplification = shown_amplification(viewer);
  return split;
}

Legend difference_legend(int amplification) {
  return {.title = "Difference of the colours",
          .ticks = {{0, "0"}, {1, fmt::format("{:.3g} / 255", 255.0 / amplification)}},
          .color = [](float t) { return glm::vec3(t); }};
}

bool verdict_is_current(const Viewer& viewer) {
  return viewer.comparison && !viewer.zoom.running &&
         viewer.comparison->view_version == viewer.view_version &&
         viewer.comparison->variant == viewer.variant();
}

std::vector<Fact> verdict_facts(const ReferenceComparison& comparison) {
  const ReferenceCheck& verdict = comparison.verdict;
  const ImageDifference& difference = verdict.difference;
  const PixelBox& box = verdict.region;
  const auto place = [](glm::ivec2 at) { return fmt::format("{}, {}", at.x, at.y); };
  std::vector<Fact> facts = {
      {"frame", full_name(comparison.variant)},
      {"pixels",
       fmt::format("{} x {} from {}", box.x1 - box.x0, box.y1 - box.y0, place({box.x0, box.y0}))},
      {"verdict", difference.first ? fmt::format("{} differ by more than {}/255",
                                                 grouped(difference.pixels), comparison.tolerance)
                                   : fmt::format("equal within {}/255", comparison.tolerance)},
      {"PSNR", decibels(difference.psnr) + " dB"},
      {"largest error", difference.largest == 0 ? "0"
                                                : fmt::format("{}/255 at {}", difference.largest,
                                                              place(difference.largest_at))}};
  if (!difference.first) return facts;
  facts.push_back({"first pixel", fmt::format("{} in tile {}, ringed in the picture",
                                              place(*difference.first), verdict.tile)});
  facts.push_back({"reason", verdict.gaussian
                                 ? fmt::format("Gaussian {}: the frame {}", *verdict.gaussian,
                                               disagreement_text(verdict.why))
                                 : fmt::format("the pixel {}", disagreement_text(verdict.why))});
  return facts;
}

std::string photograph_text(const Viewer& viewer) {
  const ShownPhotograph& photograph = viewer.photograph;
  std::string text = "photograph " + photograph.path.filename().string();
  const std::optional<PhotographQuality>& found = photograph.quality;
  if (!found || found->version != viewer.version) return text;
  if (!found->problem.empty()) return text + " \u00b7 " + found->problem;
  return text + fmt::format(" \u00b7 PSNR {} dB, SSIM {:.3f}", decibels(found->psnr), found->ssim);
}

std::string log_time(const LogEntry& entry) {
  const int seconds = static_cast<int>(entry.time);
  return fmt::format("{}:{:02}", seconds / 60, seconds % 60);
}

std::vector<std::string> hint_texts(const Hints& hints) {
  std::vector<std::string> texts;
  if (hints.fly) texts.emplace_back("W A S D: fly");
  if (hints.modes) texts.push_back(fmt::format("1 to {}: modes", culler_count()));
  if (hints.map) texts.emplace_back("H: heat map");
  if (hints.zoom) texts.emplace_back("Z: record the zoom");
  return texts;
}

std::string fitting_parts(std::string text, std::string_view separator,
                          const std::function<bool(const std::string&)>& fits) {
  while (!fits(text)) {
    const std::size_t end = text.rfind(separator);
    if (end == text.npos) break;
    text.resize(end);
  }
  return text;
}

std::size_t letters_of(const std::string& text) { return begins_of(text).size() - 1; }

std::string shortened_middle(const std::string& text, std::size_t most) {
  const std::vector<std::size_t> begins = begins_of(text);
  const std::size_t letters = begins.size() - 1;
  most = std::max<std::size_t>(most, 3);
  if (letters <= most) return text;
  const std::size_t head = (most - 1) / 3, tail = most - 1 - head;
  return text.substr(0, begins[head]) + "\u2026" + text.substr(begins[letters - tail]);
}

}  // namespace qs
