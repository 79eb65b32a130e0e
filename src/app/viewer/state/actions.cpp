// SPDX-License-Identifier: MIT
#include "app/viewer/state/actions.h"

#include <algorithm>
#include <iterator>

#include <fmt/format.h>

#include "app/framing/scene_box.h"
#include "app/viewer/state/camera_actions.h"
#include "app/viewer/state/edit_actions.h"
#include "app/viewer/state/kept_work.h"
#include "app/viewer/state/measure_actions.h"
#include "app/viewer/state/mode_numbers.h"
#include "app/viewer/state/panel_text.h"
#include "app/viewer/state/samples.h"
#include "app/viewer/state/training_actions.h"
#include "base/error.h"
#include "base/text.h"
#include "io/camera/cameras.h"

namespace qs {

void ViewerStore::apply(const Action& action, Host& host) {
  try {
    action(viewer_, host);
  } catch (const Error& error) {
    action::notify_error(viewer_, error.what());
  }
}

namespace action {
namespace {

constexpr double kToastSeconds = 5, kErrorSeconds = 12, kFileSeconds = 15;
constexpr double kReleasedSeconds = 2;  ///< least, after the mouse left the messages
constexpr std::size_t kMostRecent = 10, kMostFrames = 120;
constexpr std::size_t kMostLogEntries = 200;

void add_recent(Viewer& v, const std::filesystem::path& path) {
  std::erase(v.recent, path);
  v.recent.insert(v.recent.begin(), path);
  if (v.recent.size() > kMostRecent) v.recent.resize(kMostRecent);
}

// Shows a message for some seconds, and keeps it in the log.
void show(Viewer& v, Toast toast, double seconds = kToastSeconds) {
  v.log.push_back({v.now, toast.text, toast.error, toast.path});
  if (v.log.size() > kMostLogEntries) v.log.pop_front();
  toast.until = v.now + seconds;
  v.toasts.push_back(std::move(toast));
}

void restore_view(Viewer& v) {
  const std::optional<Camera> last = last_view(v, v.scene->path);
  if (!last) return;
  set_camera(v, *last);
  notify(v, "restored the last view of this scene; Home goes to the first view");
}

void play_on(Viewer& v, double seconds) {
  if (!v.playback.running || v.keyframes.size() < 2) return;
  seek(v, v.playback.time + seconds);
  if (v.playback.time < v.path_end()) return;
  if (v.loops_path) v.playback.time = v.keyframes.front().time;
  v.playback.running = v.loops_path;
}

// Messages about oddities that a user can correct with a key or a switch.
// `is_new`: this file was never open before.
void say_what_is_odd(Viewer& v, bool is_new) {
  if (v.scene->framing.upside_down) {
    show(v, {.text = "The scene seems to be upside down: press Y to turn it",
             .offer = ToastOffer::next_axes});
  } else if (is_new && v.offers_views && v.scene->framing.up_is_assumed) {
    show(v, {.text = "Without a floor nothing shows which side is up: Y tries other axes, Shift+Y "
                     "turns the scene over, U makes a view upright that you rolled",
             .offer = ToastOffer::turn_over});
  }
  if (!v.scene->cameras_warning.empty()) show(v, {.text = v.scene->cameras_warning});
  if (v.scene->huge > 0)
    show(v, {.text = huge_text(v.scene->huge) +
                     " and may cover it: the panel Scene and render settings (I) leaves them out",
             .offer = ToastOffer::skip_huge});
}

/// One function for each result of an opening.
struct EndOfOpening {
  Viewer& v;
  Host& host;

  void operator()(const OpenedScene& opened) const {
    v.levels.reset();
    scene_opened(v, host, opened);
  }
  void operator()(const SceneBeside& scene) const { beside_opened(v, scene); }
  void operator()(const OpenedCameras& opened) const { cameras_opened(v, host, opened); }
  void operator()(const OpenedPath& opened) const {
    std::vector<Keyframe> keyframes = opened.keyframes;
    for (Keyframe& keyframe : keyframes)
      if (v.scene) keyframe.camera = keyframe.camera.placed(v.scene->origin);
    set_keyframes(v, keyframes);
  }
  void operator()(const OpeningFailed& failed) const {
    show(v, {.text = failed.sentence, .error = true, .about_opening = true}, kErrorSeconds);
  }
  void operator()(const OpeningCancelled& cancelled) const {
    if (!cancelled.sentence.empty()) notify(v, cancelled.sentence);
  }
};

// The row of the same mode and pipeline; null if there is none.
BenchRow* row_like(std::vector<BenchRow>& rows, const BenchRow& wanted) {
  const auto found = std::ranges::find_if(rows, [&](const BenchRow& row) {
    return row.mode == wanted.mode && row.pipeline == wanted.pipeline;
  });
  return found == rows.end() ? nullptr : &*found;
}

}  // namespace

void notify(Viewer& v, std::string text) { show(v, {.text = std::move(text)}); }

void notify_error(Viewer& v, std::string text) {
  show(v, {.text = std::move(text), .error = true}, kErrorSeconds);
}

void notify_file(Viewer& v, const std::filesystem::path& file, const std::string& more) {
  std::error_code error;  // without a current folder the path stays as it is
  std::filesystem::path path = std::filesystem::absolute(file, error).lexically_normal();
  if (error) path = file;
  show(v, {.text = fmt::format("wrote {}{}", path.string(), more), .path = path}, kFileSeconds);
}

void dismiss_toast(Viewer& v, std::size_t index) {
  if (index < v.toasts.size())
    v.toasts.erase(v.toasts.begin() + static_cast<std::ptrdiff_t>(index));
}

void hold_toasts(Viewer& v, bool held) {
  v.toasts_held = held;
  if (held) return;
  for (Toast& toast : v.toasts) toast.until = std::max(toast.until, v.now + kReleasedSeconds);
}

void copy_text(Viewer& v, Host& host, const std::string& text) {
  host.set_clipboard(text);
  notify(v, "copied to the clipboard");
}

void picture_changed(Viewer& v) { ++v.version; }

void view_changed(Viewer& v) {
  ++v.version;
  ++v.view_version;
}

void set_mode(Viewer& v, CullMode mode) {
  if (mode == v.settings.mode || mode < 1 || mode > mode_count()) return;
  require_scene(v);
  v.previous_mode = std::exchange(v.settings.mode, mode);
  v.mode_switch = {v.previous_mode, mode, v.now};
  v.hints.modes = false;
  ++v.mode_changes;
  picture_changed(v);
}

void peek_previous_mode(Viewer& v, bool held) {
  if (v.peeking == held) return;
  const CullMode before = v.mode();
  v.peeking = held;
  v.mode_switch = {before, v.mode(), v.now};
  ++v.mode_changes;
  picture_changed(v);
}

void change_split(Viewer& v, const Split& split) {
  const bool another = split.other != v.split.other;
  v.split = split;
  if (another && v.panels.split) picture_changed(v);
}

void set_baseline(Viewer& v, CullMode mode) {
  if (mode < 1 || mode > culler_count() || mode == v.baseline) return;
  v.baseline = mode;
  if (v.heatmap) picture_changed(v);  // it gives heat maps their scale
}

void show_heatmap(Viewer& v, HeatQuantity quantity) {
  v.hints.map = false;
  v.last_heatmap = quantity;
  v.heatmap = quantity;
  v.quantity = Quantity::color;
  picture_changed(v);
}

void show_quantity(Viewer& v, Quantity quantity) {
  v.quantity = quantity;
  if (quantity != Quantity::color) {
    v.last_quantity = quantity;
    v.heatmap.reset();
  }
  picture_changed(v);
}

void change_heat_view(Viewer& v, const HeatView& heat_view) {
  const bool redraws = heat_view.maximum != v.heat_view.maximum ||
                       (v.shows_grid && heat_view.style != v.heat_view.style);
  v.heat_view = heat_view;
  v.heat_view.style.opacity = std::clamp(heat_view.style.opacity, 0.0f, 1.0f);
  if (redraws && v.heatmap) picture_changed(v);
}

void change_settings(Viewer& v, const RenderSettings& settings) {
  v.settings = settings;
  view_changed(v);
}

void toggle_panel(Viewer& v, bool Panels::*panel) {
  v.panels.*panel = !(v.panels.*panel);
  if (panel == &Panels::recorder) v.hints.zoom = false;
  if (panel != &Panels::split) return;
  if (v.split.other == v.variant()) v.split.other.mode = v.previous_mode;
  picture_changed(v);
}

void set_bar_width(Viewer& v, float Bars::*bar, float letters) {
  v.bars.*bar = std::clamp(letters, 1.0f, 1000.0f);
}

void toggle_option(Viewer& v, bool Viewer::*option) { v.*option = !(v.*option); }

void toggle_photograph(Viewer& v, Host& host) {
  if (!v.scene || v.scene->photographs.empty())
    return notify(v, "no photographs were found in a folder 'images' beside the cameras");
  v.panels.photograph = !v.panels.photograph;
  if (v.panels.photograph && v.dataset_camera < 0) step_camera(v, host, CameraStep::nearest);
  read_photograph(v, host);
}

void set_photograph_opacity(Viewer& v, float opacity) { v.photograph_opacity = opacity; }
void set_photograph_wipe(Viewer& v, float share) {
  v.photograph_wipe = std::clamp(share, 0.0f, 1.0f);
}

void open(Viewer& v, Host& host, const std::filesystem::path& path) {
  if (v.scene && path.string().ends_with(".edits.json")) return open_edits(v, host, path);
  if (v.scene && path.string().ends_with(".measures.json")) return open_measures(v, host, path);
  leave(v, host, path);
}

void skip_huge(Viewer& v, Host& host, bool skips) {
  v.skips_huge = skips;
  if (v.scene) host.open(v.scene->path, v.scene->axes);
}

void toggle_open_dialog(Viewer& v, Choosing choosing) {
  v.choosing = choosing;
  toggle_panel(v, &Panels::open);
}

void path_chosen(Viewer& v, Host& host, const std::filesystem::path& path, Choosing choosing) {
  if (choosing == Choosing::scene) return open(v, host, path);
  if (choosing == Choosing::scene_beside) return host.open_beside(path);
  if (choosing == Choosing::results) return host.save_results(path);
  v.train_form.data = path.string();
}

void cancel_loading(Viewer& v, Host& host) {
  host.cancel_loading();
  end_progress(v);
}

void cancel_running(Viewer& v, Host& host) {
  if (v.zoom.running || v.zoom.starting) return host.stop_job();
  if (v.loading) cancel_loading(v, host);
}

void results_kept(Viewer& v, const std::string& name, const std::string& reason) {
  v.unsaved_results += (v.unsaved_results.empty() ? "" : " and a ") + name;
  const std::string text = fmt::format("{}; the {} stays in memory", reason, name);
  show(v, {.text = text, .error = true, .offer = ToastOffer::save_results}, kErrorSeconds);
}

void results_saved(Viewer& v) {
  v.unsaved_results.clear();
  std::erase_if(v.toasts, [](const Toast& t) { return t.offer == ToastOffer::save_results; });
}

void tick(Viewer& v, const Turn& turn, double seconds) {
  static_cast<Turn&>(v) = turn;
  if (v.mode_switch && v.now - v.mode_switch->at > kSwitchSeconds) v.mode_switch.reset();
  if (!v.toasts_held)
    std::erase_if(v.toasts, [&](const Toast& toast) { return toast.until < v.now; });
  if (v.scene && v.hints.since < 0) v.hints.since = v.now;
  if (v.hints.since >= 0 && v.now - v.hints.since > kHintSeconds) v.hints = {};
  advance_motion(v, seconds);
  play_on(v, seconds);
  if (v.still() && !v.playback.running) complete_move(v);
}

void show_progress(Viewer& v, const Loading& loading) {
  const bool begins = !v.loading || v.loading->what != loading.what;
  const double began = begins ? v.now : v.loading->began;
  v.loading = loading;
  v.loading->began = began;
}
void end_progress(Viewer& v) { v.loading.reset(); }

void scene_opened(Viewer& v, Host& host, const OpenedScene& opened) {
  const ViewedScene& scene = opened.facts;
  const bool other_file = !v.scene || v.scene->path != scene.path;
  const bool turned = !other_file && v.scene->axes != scene.axes;
  const bool another = other_file || turned;
  const bool is_new = other_file && is_unknown(v, scene);
  if (v.scene) v.last_views[v.scene->path.string()] = format_camera(v.camera);
  keep_work(v);
  if (other_file) v.levels.reset();
  const CullMode mode = v.settings.mode;
  v.scene = scene;
  v.settings = opened.settings;
  v.settings.mode = mode;
  v.backend = opened.backend;
  add_recent(v, scene.path);
  restore_work(v, another);
  offer_edits(v);
  if (another) {
    restore_measures(v, host);
    v.playback = {};
    forget_zoom_views(v.zoom);
    v.counts = {};
    forget_live_times(v);
    v.inspected.reset();
    v.comparison.reset();
    set_first_view(v, host);
    say_what_is_odd(v, is_new);
  }
  view_changed(v);
  if (!turned) restore_view(v);  // the last view of a turned scene looks elsewhere
  if (another) v.history = {};
  complete_move(v);
  if (is_new && v.offers_views) offer_views(v);
}

void beside_opened(Viewer& v, const SceneBeside& scene) {
  v.beside = scene;
  v.panels.split = true;
  add_recent(v, scene.path);
  picture_changed(v);
}

void backend_changed(Viewer& v, Backend backend) {
  v.backend = backend;
  v.numbers = {};
  view_changed(v);
}

void cameras_opened(Viewer& v, Host& host, const OpenedCameras& opened) {
  if (!v.scene) return;
  v.scene->cameras = opened.cameras;
  v.scene->cameras_file = opened.file;
  v.scene->photographs = opened.photographs;
  use_cameras(*v.scene);
  set_first_view(v, host);
  notify(v, fmt::format("{} from {}", counted(opened.cameras.size(), "camera"),
                        opened.file.filename().string()));
  if (!opened.warning.empty()) show(v, {.text = opened.warning});
}

void opening_ended(Viewer& v, Host& host, const OpeningResult& result) {
  const bool opened = !std::holds_alternative<OpeningFailed>(result) &&
                      !std::holds_alternative<OpeningCancelled>(result);
  if (opened) std::erase_if(v.toasts, [](const Toast& toast) { return toast.about_opening; });
  std::visit(EndOfOpening{v, host}, result);
}

void photograph_opened(Viewer& v, const ShownPhotograph& photograph) {
  if (photograph.path == v.photograph.path) v.photograph = photograph;
}

void photograph_compared(Viewer& v, const std::filesystem::path& photograph,
                         const PhotographQuality& quality) {
  if (photograph != v.photograph.path) return;
  if (quality.version < 0) v.photograph.compared = -1;
  v.photograph.quality = quality;
}

void levels_made(Viewer& v, const LevelFacts& facts) {
  v.levels = facts;
  for (const std::string& sentence : facts.sentences) notify(v, sentence);
  if (facts.is_new) view_changed(v);
}

void frame_shown(Viewer& v, const ShownFrame& frame) {
  ++v.frames;
  learn_from_frame(v, frame);
  v.shown = frame;
  if (!frame.mode_pairs.empty())
    v.counts = {frame.view_version, frame.counted_size, v.frames, frame.mode_pairs};
  if (is_training(v))
    v.training->budget.spent(v.now, static_cast<double>(frame.stats.frame_ms) / 1000,
                             v.moving() ? DrawingBudget::kMoving : DrawingBudget::kResting);
  if (frame.divisor > 1) return;
  v.frame_ms.push_back(frame.stats.frame_ms);
  if (v.frame_ms.size() > kMostFrames) v.frame_ms.pop_front();
}

void numbers_measured(Viewer& v, const ModeNumbers& numbers) {
  const ModeNumbers before = std::exchange(v.numbers, numbers);
  if (before.version != numbers.version) return;
  // Rows of the same view that were not measured again, such as the other pipeline's, stay.
  for (const BenchRow& old : before.rows)
    if (row_like(v.numbers.rows, old) == nullptr) v.numbers.rows.push_back(old);
}

void numbers_refined(Viewer& v, const ModeNumbers& more) {
  if (v.numbers.version != more.version || v.numbers.complete) return;
  for (const BenchRow& added : more.rows)
    if (BenchRow* row = row_like(v.numbers.rows, added)) add_frames(*row, added);
}

void pixel_inspected(Viewer& v, const InspectedView& view) {
  v.inspected = view;
  ++v.inspections;
}

void compared_with_reference(Viewer& v, const ReferenceComparison& comparison) {
  v.comparison = comparison;
  // Otherwise a panel shows the result.
  if (!v.panels.all || !verdict_is_current(v)) notify(v, comparison.sentence);
}

void dismiss_comparison(Viewer& v) { v.comparison.reset(); }

}  // namespace action
}  // namespace qs
