// SPDX-License-Identifier: MIT
#include "app/viewer/state/hud_text.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "app/inspect/inspection.h"
#include "app/session/removal_text.h"
#include "app/viewer/state/camera_actions.h"
#include "app/viewer/state/crop_actions.h"
#include "app/viewer/state/kept_work.h"
#include "app/viewer/state/layout.h"
#include "app/viewer/state/lost.h"
#include "app/viewer/state/measure_actions.h"
#include "app/viewer/state/mode_table.h"
#include "app/viewer/state/panel_text.h"
#include "app/viewer/state/samples.h"
#include "app/viewer/state/training_actions.h"
#include "app/viewer/state/zoom_actions.h"
#include "base/text.h"
#include "io/bytes/json_text.h"
#include "io/camera/cameras.h"
#include "io/camera/lens_views.h"

namespace qs {

std::string signed_text(std::int64_t number) {
  const auto size = static_cast<std::uint64_t>(number < 0 ? -number : number);
  return (number < 0 ? "\u2212" : "+") + grouped(size);
}

namespace {

bool is_measured_size(const Viewer& viewer) {
  return size_of(measured_camera(viewer)) == size_of(viewer.camera);
}

// The row of the table that is of the view in the window; null if there is none, or if the picture
// shows more than the colours of one mode.
const BenchRow* row_of_picture(const Viewer& viewer) {
  const ShownFrame& shown = viewer.shown;
  if (!numbers_are_current(viewer) || shown.version != viewer.version || shown.divisor > 1 ||
      !hud_caveat(viewer).empty())
    return nullptr;
  const BenchRow* row = measured_row(viewer, shown.mode, viewer.settings.pipeline);
  return row != nullptr && row->fps_median > 0 ? row : nullptr;
}

// The numbers of the mode in the window, all of one size.
struct PictureNumbers {
  std::string ms, fps;  // empty: unknown
  std::string pairs;
  std::string time_at, pairs_at;                // " at 1/2" if they are of a reduced frame
  std::uint32_t visible = 0, largest_tile = 0;  // 0: unknown if hidden Gaussians were left out
  std::string elsewhere = {};  // "1280 x 720" if the table and the picture differ in their size
};

// The time of the last picture, and its pairs at its full size, or the pairs of a reduced frame,
// which say so.
PictureNumbers numbers_of_shown(const Viewer& viewer) {
  const RenderStats& stats = viewer.shown.stats;
  const std::string size = size_text(viewer.shown.divisor);
  PictureNumbers numbers{
      {}, {}, grouped(stats.tile_pairs), size, size, stats.visible, stats.max_pairs_in_a_tile};
  if (stats.is_occluded) {
    numbers.pairs = grouped(stats.listed);
    numbers.pairs_at = " listed" + size;
  } else if (const std::optional<FullSizePairs> full = full_size_pairs(viewer)) {
    numbers.pairs = (full->exact ? "" : "~") + grouped(full->pairs);
    numbers.pairs_at.clear();
  }
  // In flight the numbers of the table, which counts some frames only.
  const std::optional<LiveCount> live_count = live_pairs(viewer, viewer.shown.mode);
  if (live_count && viewer.moving() && shows_counts(viewer)) {
    numbers.pairs = count_text(*live_count);
    numbers.pairs_at.clear();
    numbers.visible = live_count->visible;
  }
  if (numbers_are_current(viewer) && !is_measured_size(viewer))
    numbers.elsewhere = fmt::format("{} x {}", viewer.camera.width, viewer.camera.height);
  if (stats.frame_ms <= 0) return numbers;
  const double ms = static_cast<double>(stats.frame_ms);
  const std::optional<LiveRate> live = live_rate(viewer, viewer.shown.mode);
  const double fps = live ? live->fps : 1000 / ms;
  numbers.ms = "~" + rough(1000 / fps);
  numbers.fps = "~" + rough(fps);
  return numbers;
}

// Of the table if it is of the view in the window.
PictureNumbers numbers_of_picture(const Viewer& viewer) {
  const BenchRow* row = row_of_picture(viewer);
  if (row == nullptr) return numbers_of_shown(viewer);
  const std::optional<double> spread = spread_ms(*row);
  return {time_text(row->ms_median, spread),
          rate_text(row->ms_median, spread),
          grouped(row->pairs),
          "",
          "",
          row->visible,
          row->max_tile,
          is_measured_size(viewer) ? "" : numbers_size(viewer)};
}

std::string rate_of(const PictureNumbers& numbers) {
  return fmt::format("{} ms, {} FPS{}", numbers.ms, numbers.fps, numbers.time_at);
}

// The numbers of two scenes beside each other, in the order of their names.
std::vector<std::string> numbers_of_both(const Viewer& viewer) {
  const RenderStats* stats[] = {&viewer.shown.stats, &viewer.shown.other->stats};
  if (viewer.split.flipped) std::swap(stats[0], stats[1]);
  const auto ms = [](const RenderStats* s) {
    return "~" + rough(static_cast<double>(s->frame_ms));
  };
  return {
      fmt::format("{}", fmt::join(split_names(viewer), " | ")), mode_name(viewer.mode()),
      fmt::format("{} | {} ms", ms(stats[0]), ms(stats[1])),
      fmt::format("{} | {} pairs", grouped(stats[0]->tile_pairs), grouped(stats[1]->tile_pairs))};
}

std::string visible_text(const Viewer& viewer, std::uint32_t visible, const std::string& all) {
  return fmt::format("{} of {}{}", grouped(visible), all,
                     has_faces(viewer.settings.lens) ? ", counted in each face" : "");
}

std::vector<std::string> numbers_of_frame(const Viewer& viewer) {
  const PictureNumbers numbers = numbers_of_picture(viewer);
  std::vector<std::string> words = {mode_name(viewer.mode())};
  if (!numbers.elsewhere.empty()) words.front() += " at " + numbers.elsewhere;
  if (!numbers.fps.empty()) words.push_back(rate_of(numbers));
  words.push_back(numbers.pairs + " pairs" + numbers.pairs_at);
  const std::string all = counted(viewer.shown.stats.gaussians, "Gaussian");
  words.push_back(viewer.shown.stats.is_occluded ? all + ", hidden ones left out"
                                                 : visible_text(viewer, numbers.visible, all));
  return words;
}

using nlohmann::ordered_json;

void add_facts(ordered_json& json, const std::vector<Fact>& facts) {
  for (const Fact& fact : facts) json[fact.label] = fact.value;
}

ordered_json view_json(const Viewer& viewer) {
  const bool has_view = viewer.camera.width > 0 && viewer.scene;
  const Camera measured = measured_camera(viewer);
  return {{"scene", viewer.scene ? viewer.scene->name : ""},
          {"gaussians", viewer.scene ? viewer.scene->gaussians : 0},
          {"mode", mode_name(viewer.mode())},
          {"backend", kBackendNames[static_cast<int>(viewer.backend)]},
          {"pipeline", kPipelineNames[static_cast<int>(viewer.settings.pipeline)]},
          {"camera", has_view ? camera_json(viewer.camera) : ordered_json()},
          {"axes", viewer.scene ? viewer.scene->axes : ""},
          {"dataset_camera", viewer.dataset_camera},
          {"seconds", viewer.now},
          {"frames", viewer.frames},
          {"divisor", viewer.shown.divisor},
          {"interop", viewer.shown.interop},
          {"present_ms", {{"into_gl", viewer.shown.stats.present_ms}, {"draw", viewer.present_ms}}},
          {"caveat", hud_caveat(viewer)},
          {"line", status_line(viewer).numbers},
          {"numbers_are_current", numbers_are_current(viewer)},
          {"numbers_suffice", numbers_suffice(viewer)},
          {"frames_behind", frames_behind(viewer.numbers)},
          {"baseline", mode_name(viewer.baseline)},
          {"status", viewer.drawn_status},
          {"columns", viewer.drawn_columns},
          {"measured_size", {measured.width, measured.height}}};
}

ordered_json mode_json(const Viewer& viewer, const HudRow& row) {
  const std::optional<LiveCount> live = live_pairs(viewer, row.mode);
  return {{"mode", row.name.text},
          {"live_pairs", live ? ordered_json(live->tile_pairs) : ordered_json()},
          {"live_frames_ago", live ? ordered_json(live->frames_ago) : ordered_json()},
          {"ms_median", row.ms.value},
          {"ms", row.ms.text},
          {"fps", row.fps.text},
          {"fps_value", row.fps.value},
          {"is_live", row.is_live},
          {"pairs", row.pairs.text},
          {"per_visible", row.per_visible.text},
          {"unused", row.unused.text},
          {"ratio", row.ratio.text},
          {"noisy", row.ms.noisy},
          {"ratio_noisy", row.ratio.noisy},
          {"other_ms", row.other_ms.text},
          {"other_ratio", row.other_ratio.text}};
}

ordered_json split_json(const Viewer& viewer, const ShownOther& other) {
  const PixelBox& region = other.region;
  ordered_json json = {{"first", full_name(viewer.variant())},
                       {"other", full_name(other.variant)},
                       {"view", kSplitViews[static_cast<int>(viewer.split.view)]},
                       {"divider", viewer.split.divider},
                       {"amplification", shown_amplification(viewer)},
                       {"flipped", viewer.split.flipped},
                       {"region", {region.x0, region.y0, region.x1, region.y1}}};
  if (other.scene) json["scenes"] = names_of_scenes(viewer, *other.scene);
  add_facts(json, split_facts(viewer));
  return json;
}

// The heatmap, the value map, the split and the crop of the shown picture.
void add_overlays(const Viewer& viewer, ordered_json& json) {
  if (viewer.shown.heatmap) {
    json["heatmap"] = {{"quantity", heatmap_row(viewer.shown.heatmap->quantity).name},
                       {"total", viewer.shown.heatmap->total},
                       {"max", viewer.shown.map_scale.maximum},
                       {"scale", scale_text(viewer)}};
    if (viewer.shown.other && viewer.shown.other->heatmap)
      json["heatmap"]["other_total"] = viewer.shown.other->heatmap->total;
    if (viewer.shown.missed) json["heatmap"]["missed"] = missed_sentence(*viewer.shown.missed);
  }
  if (viewer.shown.values) {
    const ValueMap& map = *viewer.shown.values;
    json["picture"] = {
        {"quantity", row_of(map.quantity).name}, {"low", map.scale.low}, {"high", map.scale.high}};
  }
  if (viewer.shown.grid) {
    for (CullMode mode = 1; mode <= culler_count(); ++mode)
      json["grid"].push_back({{"mode", mode_name(mode)}, {"label", grid_label(viewer, mode)}});
  }
  if (viewer.shown.other) json["split"] = split_json(viewer, *viewer.shown.other);
  const Editing& editing = viewer.editing;
  if (viewer.crop.wish.removes() || editing.gone || editing.selected) {
    json["crop"] = {{"text", crop_text(viewer)},
                    {"applied", editing.gone != nullptr},
                    {"selected", editing.history.state().selected.count()},
                    {"box", format_crop_box(viewer.crop.wish.box,
                                            viewer.scene ? viewer.scene->origin : glm::dvec3(0))}};
  }
  if (!viewer.scene) return;
  for (const MeasureRow& row : rows_of_measures(viewer))
    json["measures"].push_back({row.name, row.value, row.more});
  for (const Ruler& ruler : rulers_of(viewer))
    json["rulers"].push_back({{"text", ruler.text},
                              {"known", !ruler.hidden.empty()},
                              {"hidden", std::ranges::count(ruler.hidden, true)}});
}

// The help for a user who is lost or new, and the size of letters.
void add_guides(const Viewer& viewer, ordered_json& json) {
  json["arrow"] = nullptr;
  if (const std::optional<WayToSubject> way = way_to_subject(viewer)) {
    json["arrow"] = {{"tip", {way->tip.x, way->tip.y}},
                     {"direction", {way->direction.x, way->direction.y}}};
  }
  json["first_views"] = viewer.view_choice.pictures && viewer.scene
                            ? viewer.scene->candidates.size()
                            : std::size_t{0};
  json["interface_scale"] = interface_scale(viewer);
}

void add_messages(const Viewer& viewer, ordered_json& json) {
  json["hints"] = hint_texts(viewer.hints);
  json["toasts"] = ordered_json::array();
  for (const Toast& toast : viewer.toasts) json["toasts"].push_back(toast.text);
}

}  // namespace

std::vector<Fact> hud_facts(const Viewer& viewer) {
  const RenderStats& stats = viewer.shown.stats;
  const PictureNumbers numbers = numbers_of_picture(viewer);
  std::vector<Fact> facts = {
      {"render", numbers.fps.empty() ? "-" : rate_of(numbers)},
      {"display", viewer.display_fps > 0 ? fps_text(viewer.display_fps) + " FPS" : "at rest"},
      {"present",
       fmt::format("{} ms{}",
                   three_digits(static_cast<double>(stats.present_ms + viewer.present_ms)),
                   viewer.shown.interop ? ", by interop" : ", through the host")},
      {"drawn by", drawn_by({viewer.shown.mode, stats.pipeline, viewer.backend})},
      {"tile pairs", numbers.pairs + numbers.pairs_at},
  };
  if (!stats.is_occluded) {
    facts.push_back({"visible", visible_text(viewer, numbers.visible, grouped(stats.gaussians))});
    facts.push_back({"largest tile", counted(numbers.largest_tile, "pair")});
  }
  if (!numbers.elsewhere.empty()) facts.insert(facts.begin(), {"size", numbers.elsewhere});
  if (viewer.is_remote)  // these are of a window
    std::erase_if(
        facts, [](const Fact& fact) { return fact.label == "display" || fact.label == "present"; });
  const BenchRow* measured = measured_row(viewer, viewer.mode(), viewer.settings.pipeline);
  const bool of_this_size = row_of_picture(viewer) != nullptr || is_measured_size(viewer);
  if (measured != nullptr && measured->false_positives && numbers_are_current(viewer) &&
      of_this_size)
    facts.push_back({"unused", fmt::format("{} pairs, {}", grouped(*measured->false_positives),
                                           unused_text(measured))});
  if (viewer.process_bytes > 0) {
    facts.push_back(
        {"memory",
         bytes_text(viewer.process_bytes) +
             (viewer.gpu_bytes > 0 ? fmt::format(", GPU {}", bytes_text(viewer.gpu_bytes)) : "")});
  }
  return facts;
}

std::string hud_caveat(const Viewer& viewer) {
  std::vector<std::string> reasons;
  if (viewer.shown.divisor > 1)
    reasons.push_back(fmt::format("drawn at 1/{} size", viewer.shown.divisor));
  if (viewer.shown.heatmap) reasons.emplace_back("with a heat map");
  if (viewer.shown.values) reasons.emplace_back("without colours");
  if (viewer.shown.other) reasons.emplace_back("in a split window");
  if (viewer.shown.grid) reasons.emplace_back("beside all modes");
  if (viewer.shown.stats.is_occluded) reasons.emplace_back("without hidden Gaussians");
  if (is_training(viewer)) reasons.emplace_back("beside the trainer");
  if (!viewer.on_demand && viewer.vsync) reasons.emplace_back("waits for the display");
  return reasons.empty() ? "" : joined(reasons, ", ") + ": not a measurement";
}

StatusLine status_line(const Viewer& viewer) {
  StatusLine line;
  if (viewer.remote) {
    line.numbers = "training at " + viewer.remote->address;
    if (viewer.frames > 0)
      line.numbers += fmt::format("  \u00b7  picture after {:.0f} ms",
                                  static_cast<double>(viewer.shown.stats.frame_ms));
    line.note = remote_state(*viewer.remote);
    line.caution = !viewer.remote->problem.empty();
    return line;
  }
  if (viewer.loading && !viewer.scene) {
    line.numbers = fmt::format("loading {}", viewer.loading->path.filename().string());
    if (viewer.frames > 0) line.note = "a coarse picture until the rest is read";
    return line;
  }
  const bool both = viewer.shown.other && viewer.shown.other->scene;
  std::vector<std::string> words = both ? numbers_of_both(viewer) : numbers_of_frame(viewer);
  if (viewer.levels)
    words.push_back(fmt::format("{} of {} pages, {} missing", viewer.levels->stream.resident,
                                viewer.levels->stream.pages, viewer.levels->missing));
  if (const std::string altered = alterations_of(viewer).brief; !altered.empty())
    words.push_back(altered);
  if (viewer.display_fps > 0) words.push_back(fps_text(viewer.display_fps) + " pictures a second");
  line.numbers = joined(words, "  \u00b7  ");
  line.faint = viewer.shown.divisor > 1;
  line.note = running_text(viewer);
  if (!line.note.empty() && !viewer.is_remote) line.note += "   Esc: cancel";
  if (line.note.empty()) line.note = hud_caveat(viewer);
  line.caution = !line.note.empty();
  if (line.caution) return line;
  const bool flies = viewer.navigation == Navigation::fly || viewer.flight.distance > 0;
  if (flies) {
    line.note = fmt::format("flying {:.3g} units a second", flying_speed(viewer));
  } else if (!viewer.panels.hud) {
    line.note = "F10: all modes   F1: keys";
  }
  return line;
}

std::string window_title(const Viewer& viewer) {
  std::vector<std::string> words;
  if (const std::string runs = running_text(viewer); !runs.empty()) words.push_back(runs);
  if (viewer.scene) {
    const std::string altered = alterations_of(viewer).brief;
    words.push_back(viewer.scene->name + (altered.empty() ? "" : fmt::format(" ({})", altered)));
  }
  words.emplace_back("quadsplat");
  return joined(words, " - ");
}

std::string hud_status(const Viewer& viewer) {
  if (viewer.zoom.running) return "recording a zoom";
  if (numbers_are_current(viewer)) {
    const std::size_t frames = frames_behind(viewer.numbers);
    std::string text = "all modes measured off screen for this view";
    if (!viewer.numbers.rows.empty() && viewer.numbers.rows.front().width > 0)
      text += fmt::format(" at {} x {}", viewer.numbers.rows.front().width,
                          viewer.numbers.rows.front().height);
    if (frames > 0) text += fmt::format(": medians of {} frames each", frames);
    return text + (viewer.measuring ? ", measuring more ..." : "");
  }
  if (viewer.measuring) return "measuring all modes for this view ...";
  const std::string live =
      viewer.live.pairs.empty() ? "not measured yet"
      : live_rate(viewer, viewer.shown.mode)
          ? fmt::format("in flight at {}: ~ of at least {} frames, each beside a picture",
                        numbers_size(viewer), kPairsOfMode)
          : fmt::format("in flight at {}: pairs alone", numbers_size(viewer));
  if (is_training(viewer)) return live + "; modes are not measured beside the trainer";
  if (!viewer.on_demand) return live + "; all modes are measured while drawing on demand only";
  const bool soon = viewer.still() && !viewer.playback.running;
  return soon ? "measuring all modes for this view ..."
              : live + "; measured once this view is still";
}

std::vector<std::string> badge_lines(const Viewer& viewer) {
  const PictureNumbers numbers =
      is_measured_size(viewer) ? numbers_of_picture(viewer) : numbers_of_shown(viewer);
  std::vector<std::string> lines;
  if (!numbers.fps.empty()) lines.push_back(numbers.fps + " FPS" + numbers.time_at);
  lines.push_back(numbers.pairs + " pairs" + numbers.pairs_at);
  lines.push_back(fmt::format("{} x {}", viewer.camera.width, viewer.camera.height));
  lines.push_back(drawn_by({viewer.shown.mode, viewer.shown.stats.pipeline, viewer.backend}));
  if (const std::string altered = alterations_of(viewer).brief; !altered.empty())
    lines.push_back(altered);
  return lines;
}

std::array<double, kStageCount> stages_of(const BenchRow& row) {
  return {row.preprocess_ms, row.bin_ms, row.sort_ms, row.blend_ms};
}

std::string stages_text(const BenchRow& row) {
  std::vector<std::string> lines;
  for (std::size_t stage = 0; stage < kStageCount; ++stage)
    lines.push_back(
        fmt::format("{} {}", kStageNames[stage], stage_text(row, static_cast<Stage>(stage))));
  return joined(lines, "\n");
}

std::string frame_plot_text(const Viewer& viewer) {
  const float longest = *std::max_element(viewer.frame_ms.begin(), viewer.frame_ms.end());
  return fmt::format("render ms, last {} frames, 0 to {}", viewer.frame_ms.size(),
                     three_digits(static_cast<double>(longest)));
}

std::vector<Fact> split_facts(const Viewer& viewer) {
  if (!viewer.shown.other) return {};
  const ShownOther& other = *viewer.shown.other;
  const ImageDifference& pixels = other.pixels;
  std::vector<Fact> facts = {
      {"PSNR", std::isinf(pixels.psnr) ? "equal" : decibels(pixels.psnr) + " dB"},
      {"largest error", pixels.largest == 0
                            ? "0"
                            : fmt::format("{}/255 at {}, {}", pixels.largest, pixels.largest_at.x,
                                          pixels.largest_at.y)},
      {"pixels that differ", grouped(pixels.pixels)}};
  if (other.pairs) {
    const auto [first, second] = std::pair(viewer.shown.stats.tile_pairs, other.stats.tile_pairs);
    std::string text = fmt::format("{} and {}: {}", grouped(first), grouped(second),
                                   signed_text(other.pairs->total));
    const double share = static_cast<double>(other.pairs->total) / static_cast<double>(second);
    if (share != 0 && second > 0)
      text += fmt::format(", {}{:.1f} %", share < 0 ? "\u2212" : "+", 100 * std::abs(share));
    facts.push_back({"tile pairs", text});
  }
  if (other.scene) {
    facts.push_back({"Gaussians", fmt::format("{} and {}", grouped(viewer.shown.stats.gaussians),
                                              grouped(other.scene->gaussians))});
  }
  return facts;
}

std::string state_json(const Viewer& viewer) {
  ordered_json json = view_json(viewer);
  if (viewer.training) {
    add_facts(json["training"], training_facts(viewer));
    json["training"]["shown"] = viewer.training->shown;
    if (viewer.training->views) {
      json["training"]["view"] = test_view_title(*viewer.training);
      json["training"]["of this view"] = test_view_text(viewer);
    }
  }
  if (viewer.remote) add_facts(json["remote"], remote_facts(viewer));
  json["open_dialog"] = viewer.panels.open;
  json["leaving"] = viewer.leaving ? unsaved_text(viewer, *viewer.leaving) : "";
  json["title"] = window_title(viewer);
  for (const HudRow& row : hud_rows(viewer)) json["modes"].push_back(mode_json(viewer, row));
  if (const auto facts = hud_facts(viewer); !facts.empty()) add_facts(json["facts"], facts);
  add_overlays(viewer, json);
  if (viewer.inspected) json["inspector"] = inspection_json(viewer.inspected->inspection);
  if (viewer.comparison) json["oracle"] = viewer.comparison->sentence;
  if (verdict_is_current(viewer)) add_facts(json["verdict"], verdict_facts(*viewer.comparison));
  add_messages(viewer, json);
  add_guides(viewer, json);
  if (viewer.mode_switch) json["switch"] = switch_text(viewer);
  if (viewer.shows_badge) json["badge"] = badge_lines(viewer);
  if (viewer.panels.photograph) json["photograph"] = photograph_text(viewer);
  json["keyframes"] = viewer.keyframes.size();
  json["zoom"] = zoom_json(viewer);
  return json_file_text(json);
}

}  // namespace qs
