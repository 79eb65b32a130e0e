// SPDX-License-Identifier: MIT
#include "app/viewer/commands/commands.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <iterator>

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <fmt/format.h>

#include "app/session/shot.h"
#include "app/viewer/commands/jobs.h"
#include "app/viewer/commands/keys.h"
#include "app/viewer/commands/output_file.h"
#include "app/viewer/state/actions.h"
#include "app/viewer/state/camera_actions.h"
#include "app/viewer/state/crop_actions.h"
#include "app/viewer/state/edit_actions.h"
#include "app/viewer/state/kept_work.h"
#include "app/viewer/state/layout.h"
#include "app/viewer/state/measure_actions.h"
#include "app/viewer/state/select_actions.h"
#include "app/viewer/state/training_actions.h"
#include "base/text.h"
#include "io/bytes/replace_file.h"
#include "io/camera/cameras.h"
#include "io/camera/lens_views.h"

namespace qs {

// Background jobs that only their row starts, one file each.
namespace job {
void bench_view(RenderContext& context, const Viewer& viewer);
void compare_around_cursor(RenderContext& context, const Viewer& viewer);
void compare_with_reference(RenderContext& context, const Viewer& viewer);
void save_grid(RenderContext& context, const Viewer& viewer);
void save_screenshot(RenderContext& context, const Viewer& viewer);
}  // namespace job

namespace {

using namespace action;

constexpr int kCtrl = GLFW_MOD_CONTROL, kShift = GLFW_MOD_SHIFT;

// ---- functions of single rows ------------------------------------------------------------------
void reload(Viewer& v, Host& host) {
  if (v.scene) host.open(v.scene->path, v.scene->axes);
}

void grab_window(Viewer& v, Host& host) {
  if (v.scene)
    host.grab_window(free_name(v.out_dir / "screenshots", v.scene->name + "_window", ".png"), true);
}

// A training in another program gives its picture without a renderer.
void save_screenshot(Viewer& v, Host& host) {
  if (!v.scene) return;
  if (!v.remote) return start_job(v, host, job::save_screenshot);
  const std::string stem = fmt::format("{}_{}_{}x{}", v.scene->name, camera_name(v),
                                       v.shown.camera.width, v.shown.camera.height);
  host.grab_picture(free_name(v.out_dir / "screenshots", safe_file_name(stem), ".png"));
}

void toggle_heatmap(Viewer& v) {
  if (!v.heatmap) return show_heatmap(v, v.last_heatmap);
  v.heatmap.reset();
  picture_changed(v);
}

void next_heatmap(Viewer& v) {
  const std::size_t next = (static_cast<std::size_t>(v.last_heatmap) + 1) % kHeatQuantities;
  show_heatmap(v, v.heatmap ? static_cast<HeatQuantity>(next) : v.last_heatmap);
}

void toggle_quantity(Viewer& v) {
  show_quantity(v, v.quantity == Quantity::color ? v.last_quantity : Quantity::color);
}

void next_quantity(Viewer& v) {
  constexpr auto kOthers = static_cast<int>(kQuantities.size()) - 1;  // without color
  const int last = static_cast<int>(v.last_quantity);
  show_quantity(v, v.quantity == Quantity::color ? v.last_quantity
                                                 : static_cast<Quantity>(last % kOthers + 1));
}

void scale_splats(Viewer& v, float factor) {
  v.settings.splat_scale = std::clamp(v.settings.splat_scale * factor, 0.01f, 10.0f);
  if (std::abs(v.settings.splat_scale - 1) < 1e-3f) v.settings.splat_scale = 1;
  view_changed(v);
}

void set_style(Viewer& v, DrawStyle style) {
  v.settings.style = style;
  view_changed(v);
}

void toggle_navigation(Viewer& v) {
  v.navigation = v.navigation == Navigation::orbit ? Navigation::fly : Navigation::orbit;
  notify(v, v.navigation == Navigation::orbit ? "orbit: drag turns around the pivot"
                                              : "fly: drag looks around, W A S D moves");
}

void copy_camera(Viewer& v, Host& host) {
  Camera copied = v.camera;
  if (v.scene) copied.origin = v.scene->origin;
  host.set_clipboard(format_camera(copied));
  notify(v, "camera copied as JSON, ready for --camera-json");
}

void paste_camera(Viewer& v, Host& host) {
  const Camera pasted = parse_camera(host.clipboard(), "clipboard");
  set_camera(v, v.scene ? pasted.placed(v.scene->origin) : pasted);
}

void set_lens(Viewer& v, const std::shared_ptr<const LensView>& lens) {
  v.settings.lens = lens;
  if (has_faces(lens) && (v.heatmap == HeatQuantity::missed || v.shows_grid || v.panels.split))
    notify(v, "missed contributions, the split and all modes are drawn by a pinhole camera");
  view_changed(v);
}

// Shows the pictures of all modes side by side, or the picture of one mode again.
void toggle_grid(Viewer& v) {
  v.shows_grid = !v.shows_grid;
  picture_changed(v);
}

void step_mode(Viewer& v, int by) {
  set_mode(v, (v.settings.mode - 1 + by + culler_count()) % culler_count() + 1);
}

void next_split_view(Viewer& v) {
  const auto next = (static_cast<std::size_t>(v.split.view) + 1) % std::size(kSplitViews);
  v.split.view = static_cast<SplitView>(next);
}

// ---- the table ---------------------------------------------------------------------------------
template <class Function, class... Arguments>
KeyCommand row(int key, int mods, Menu menu, const char* help, Function function,
               Arguments... arguments) {
  return {key, mods, menu, help, call(function, std::move(arguments)...)};
}

// A command that changes how this program draws.
KeyCommand drawn_here(KeyCommand command) {
  command.action = [action = std::move(command.action)](Viewer& viewer, Host& host) {
    require_scene(viewer);
    action(viewer, host);
  };
  return command;
}

KeyCommand checked(KeyCommand command, std::function<bool(const Viewer&)> is_checked) {
  command.is_checked = std::move(is_checked);
  return command;
}

KeyCommand panel(int key, int mods, Menu menu, const char* help, bool Panels::*panel) {
  KeyCommand command = checked(row(key, mods, menu, help, toggle_panel, panel),
                               [panel](const Viewer& viewer) { return viewer.panels.*panel; });
  command.panel = panel;
  return command;
}

KeyCommand always(KeyCommand command) {
  command.without_scene = true;
  return command;
}

// Draws a line above the menu's entry, which separates it from the entries above.
KeyCommand last(KeyCommand command) {
  command.line_above = true;
  return command;
}

KeyCommand asks(KeyCommand command) {
  command.opens_dialog = true;
  return command;
}

KeyCommand held(int key, int mods, const char* help, void (*function)(Viewer&, bool held)) {
  KeyCommand command = row(key, mods, Menu::none, help, function, true);
  command.on_release = call(function, false);
  return command;
}

KeyCommand job_row(int key, int mods, Menu menu, const char* help,
                   void (*function)(RenderContext&, const Viewer&)) {
  return row(key, mods, menu, help, [function](Viewer& viewer, Host& host) {
    if (viewer.scene) start_job(viewer, host, function);
  });
}

KeyCommand mode_row(CullMode mode) {
  KeyCommand command = row(GLFW_KEY_0 + mode, 0, Menu::mode, mode_name(mode), set_mode, mode);
  command.is_checked = [mode](const Viewer& viewer) { return viewer.settings.mode == mode; };
  command.tooltip = row_of(mode).summary;
  return command;
}

KeyCommand style_row(int key, const char* help, DrawStyle style) {
  return drawn_here(checked(row(key, kShift, Menu::view, help, set_style, style),
                            [style](const Viewer& v) { return v.settings.style == style; }));
}

KeyCommand measuring_row() {
  KeyCommand command =
      panel(GLFW_KEY_M, kShift, Menu::measure, "Measure distances", &Panels::measures);
  command.action = call(toggle_measuring);
  return command;
}

// The arrow keys move the cross by a pixel, with Shift by ten.
void add_cross_rows(std::vector<KeyCommand>& rows) {
  struct Arrow {
    int key;
    const char* where;
    glm::dvec2 by;
  };
  constexpr Arrow kArrows[] = {{GLFW_KEY_LEFT, "to the left", {-1, 0}},
                               {GLFW_KEY_RIGHT, "to the right", {1, 0}},
                               {GLFW_KEY_UP, "up", {0, -1}},
                               {GLFW_KEY_DOWN, "down", {0, 1}}};
  for (const Arrow& arrow : kArrows) {
    const std::string help = fmt::format("Move the cross of a tool, or the view, {}", arrow.where);
    rows.push_back(row(arrow.key, 0, Menu::none, help.c_str(), move_cross, arrow.by));
    rows.push_back(row(arrow.key, kShift, Menu::none, (help + ", 10 times as far").c_str(),
                       move_cross, 10.0 * arrow.by));
  }
}

// `view`: null for a pinhole camera.
KeyCommand lens_row(int key, const char* help, std::shared_ptr<const LensView> view) {
  return drawn_here(checked(row(key, kShift, Menu::lens, help, set_lens, view),
                            [view](const Viewer& v) { return v.settings.lens == view; }));
}

// The height of an orthographic picture follows the camera, see shown_settings().
std::shared_ptr<const LensView> shared(LensView view) {
  return std::make_shared<const LensView>(std::move(view));
}

std::vector<KeyCommand> make_commands() {
  using enum Menu;
  std::vector<KeyCommand> rows = {
      asks(always(
          checked(row(GLFW_KEY_O, kCtrl, file, "Open a file", toggle_open_dialog, Choosing::scene),
                  [](const Viewer& v) { return v.panels.open && v.choosing == Choosing::scene; }))),
      asks(checked(
          row(GLFW_KEY_O, kCtrl | kShift, file, "Open or close a scene beside", toggle_beside),
          [](const Viewer& v) { return v.beside.has_value(); })),
      asks(always(
          panel(GLFW_KEY_T, kCtrl | kShift, train, "Train from photographs", &Panels::train))),
      row(GLFW_KEY_R, kCtrl, file, "Save the cropped scene", save_crop, std::filesystem::path(),
          Action()),
      row(GLFW_KEY_F5, 0, file, "Reload", reload),
      row(GLFW_KEY_Y, 0, file, "Turn upright: read with other axes", next_axes),
      row(GLFW_KEY_F12, 0, file, "Screenshot of the window", grab_window),
      row(GLFW_KEY_F12, kCtrl, file, "Screenshot of the picture", save_screenshot),
      last(always(row(GLFW_KEY_Q, kCtrl, file, "Quit", leave, std::filesystem::path()))),

      row(GLFW_KEY_Z, kCtrl, edit, "Undo", step_back, true),
      row(GLFW_KEY_Z, kCtrl | kShift, edit, "Redo", step_back, false),
      panel(GLFW_KEY_F10, 0, measure, "FPS of all modes", &Panels::hud),
      panel(GLFW_KEY_I, 0, view, "Scene and render settings", &Panels::info),
      panel(GLFW_KEY_B, 0, view, "Inspector: boxes of a Gaussian", &Panels::inspector),
      panel(GLFW_KEY_R, 0, edit, "Crop and clean", &Panels::crop),
      checked(row(GLFW_KEY_R, kShift, edit, "Apply or undo the crop", toggle_crop),
              [](const Viewer& v) { return v.editing.gone != nullptr; }),
      row(GLFW_KEY_B, kShift, edit, "Select with the next tool", next_tool),
      row(GLFW_KEY_ESCAPE, 0, edit, "Leave the selecting tool", cancel_tool),
      row(GLFW_KEY_A, kCtrl, edit, "Select all", select_by, SelectTool::all),
      row(GLFW_KEY_A, kCtrl | kShift, edit, "Select nothing", select_by, SelectTool::none),
      row(GLFW_KEY_I, kCtrl, edit, "Invert the selection", select_by, SelectTool::invert),
      row(GLFW_KEY_PERIOD, kCtrl, edit, "Grow the selection", select_by, SelectTool::grow),
      row(GLFW_KEY_COMMA, kCtrl, edit, "Shrink the selection", select_by, SelectTool::shrink),
      row(GLFW_KEY_PERIOD, 0, edit, "Larger brush", scale_brush, 1.25f),
      row(GLFW_KEY_COMMA, 0, edit, "Smaller brush", scale_brush, 0.8f),
      row(GLFW_KEY_DELETE, 0, edit, "Remove the selected Gaussians", edit_selected,
          EditKind::remove),
      row(GLFW_KEY_DELETE, kShift, edit, "Keep only the selected Gaussians", edit_selected,
          EditKind::keep),
      row(GLFW_KEY_H, kCtrl, edit, "Hide the selected Gaussians", edit_selected, EditKind::hide),
      row(GLFW_KEY_H, kCtrl | kShift, edit, "Show hidden Gaussians again", edit_selected,
          EditKind::show),
      row(GLFW_KEY_S, kCtrl, edit, "Save the edits", save_edits),
      measuring_row(),
      row(GLFW_KEY_M, kCtrl, measure, "Copy the measures", copy_measures),
      row(GLFW_KEY_ENTER, 0, edit, "Use the cross; close the shape or the line", use_cross),
      panel(GLFW_KEY_M, 0, window, "Messages", &Panels::messages),
      panel(GLFW_KEY_T, 0, train, "Training", &Panels::training),
      row(GLFW_KEY_T, kShift, train, "Pause or resume training", toggle_training),
      row(GLFW_KEY_T, kCtrl, train, "One iteration of training", command_training,
          TrainingCommand::step),
      always(panel(GLFW_KEY_TAB, 0, window, "All windows", &Panels::all)),
      drawn_here(row(GLFW_KEY_H, 0, measure, "Heat map", toggle_heatmap)),
      drawn_here(row(GLFW_KEY_H, kShift, measure, "Next heat map", next_heatmap)),
      drawn_here(
          checked(row(GLFW_KEY_J, 0, view, "Depth or alpha instead of colours", toggle_quantity),
                  [](const Viewer& v) { return v.quantity != Quantity::color; })),
      drawn_here(
          row(GLFW_KEY_J, kShift, view, "Next of depth, median depth and alpha", next_quantity)),
      row(GLFW_KEY_EQUAL, 0, view, "Larger splats", scale_splats, 1.1f),
      row(GLFW_KEY_MINUS, 0, view, "Smaller splats", scale_splats, 1 / 1.1f),
      style_row(GLFW_KEY_1, "Draw splats", DrawStyle::splats),
      style_row(GLFW_KEY_2, "Draw points", DrawStyle::points),
      style_row(GLFW_KEY_3, "Draw ellipsoids", DrawStyle::ellipsoids),
      row(GLFW_KEY_Y, kShift, view, "Turn the scene over, and back", turn_over),
      always(row(GLFW_KEY_EQUAL, kCtrl, window, "Larger interface", step_interface_scale, 1)),
      always(row(GLFW_KEY_MINUS, kCtrl, window, "Smaller interface", step_interface_scale, -1)),
      always(row(GLFW_KEY_0, kCtrl, window, "Interface at 100 %", set_interface_scale, 1.0f)),
      always(checked(row(GLFW_KEY_L, kCtrl | kShift, window, "Light theme", toggle_option,
                         &Viewer::light_theme),
                     [](const Viewer& v) { return v.light_theme; })),
      always(row(GLFW_KEY_F11, 0, window, "Full screen",
                 [](Viewer&, Host& host) { host.toggle_fullscreen(); })),

      panel(GLFW_KEY_L, 0, camera, "Cameras and path", &Panels::cameras),
      row(GLFW_KEY_LEFT_BRACKET, 0, camera, "Previous camera", step_camera, CameraStep::previous),
      row(GLFW_KEY_RIGHT_BRACKET, 0, camera, "Next camera", step_camera, CameraStep::next),
      row(GLFW_KEY_LEFT_BRACKET, kShift, camera, "First camera", step_camera, CameraStep::first),
      row(GLFW_KEY_RIGHT_BRACKET, kShift, camera, "Last camera", step_camera, CameraStep::last),
      row(GLFW_KEY_N, 0, camera, "Nearest camera", step_camera, CameraStep::nearest),
      row(GLFW_KEY_G, 0, camera, "Photograph of this camera", toggle_photograph),
      panel(GLFW_KEY_O, 0, camera, "Cameras in the scene", &Panels::frusta),
      row(GLFW_KEY_F, 0, camera, "Frame the scene", frame_scene),
      row(GLFW_KEY_HOME, 0, camera, "First view", go_home),
      row(GLFW_KEY_HOME, kShift, camera, "Choose the first view", ask_for_views),
      row(GLFW_KEY_D, kCtrl, camera, "Bookmark this view", keep_bookmark),
      row(GLFW_KEY_BACKSPACE, 0, camera, "Back to the view before", undo_move),
      row(GLFW_KEY_BACKSPACE, kShift, camera, "Forward to the next view", redo_move),
      row(GLFW_KEY_U, 0, camera, "This view is upright", make_upright),
      row(GLFW_KEY_V, 0, camera, "Orbit or fly", toggle_navigation),
      row(GLFW_KEY_C, kCtrl, camera, "Copy the camera as JSON", copy_camera),
      row(GLFW_KEY_V, kCtrl, camera, "Paste a camera", paste_camera),
      row(GLFW_KEY_K, 0, camera, "Set a keyframe", add_keyframe),
      row(GLFW_KEY_SPACE, 0, camera, "Play the path", toggle_playback),
      row(GLFW_KEY_K, kCtrl, camera, "Film of the path, or round the scene", film),

      lens_row(GLFW_KEY_5, "Pinhole camera", nullptr),
      lens_row(GLFW_KEY_6, "Panorama of 360 degrees", shared(panorama_view(360))),
      lens_row(GLFW_KEY_7, "Fisheye of 180 degrees", shared(fisheye_view(180))),
      lens_row(GLFW_KEY_8, "Orthographic", shared(parallel_view(1))),

      drawn_here(held(GLFW_KEY_GRAVE_ACCENT, 0, "Previous mode, while held", peek_previous_mode)),
      row(GLFW_KEY_COMMA, kShift, mode, "Mode before in the list", step_mode, -1),
      row(GLFW_KEY_PERIOD, kShift, mode, "Next mode in the list", step_mode, 1),
      checked(row(GLFW_KEY_I, kShift, mode, "Mode and numbers over the picture", toggle_option,
                  &Viewer::shows_badge),
              [](const Viewer& v) { return v.shows_badge; }),
      drawn_here(checked(row(GLFW_KEY_F9, 0, mode, "All modes side by side", toggle_grid),
                         [](const Viewer& v) { return v.shows_grid; })),
      job_row(GLFW_KEY_F9, kCtrl, mode, "Figure of all modes", job::save_grid),
      drawn_here(panel(GLFW_KEY_C, 0, mode, "Split: beside another mode or scene", &Panels::split)),
      drawn_here(row(GLFW_KEY_C, kShift, mode, "Next view of the split", next_split_view)),
      drawn_here(row(GLFW_KEY_X, 0, mode, "Flip the split",
                     [](Viewer& v) { v.split.flipped = !v.split.flipped; })),

      panel(GLFW_KEY_Z, 0, measure, "Zoom recorder", &Panels::recorder),
      checked(row(GLFW_KEY_Z, kShift, measure, "Record a zoom", toggle_zoom_recording),
              [](const Viewer& v) { return v.zoom.running; }),
      job_row(GLFW_KEY_P, 0, measure, "Bench this view", job::bench_view),
      job_row(GLFW_KEY_0, 0, measure, "Compare with the reference", job::compare_with_reference),
      job_row(GLFW_KEY_0, kShift, measure, "The same around the cursor",
              job::compare_around_cursor),

      always(panel(GLFW_KEY_F1, 0, help, "Keys and mouse", &Panels::help)),
      asks(always(
          panel(GLFW_KEY_P, kCtrl | kShift, help, "Find a command by words", &Panels::palette))),
  };
  add_cross_rows(rows);
  auto at = std::ranges::find(rows, Menu::none, &KeyCommand::menu) + 1;
  for (CullMode number = 1; number <= culler_count(); ++number)
    at = rows.insert(at, mode_row(number)) + 1;
  return rows;
}

// Digits, plus and minus of the keypad count as the keys of the main row.
int key_of_main_row(int key) {
  if (key >= GLFW_KEY_KP_0 && key <= GLFW_KEY_KP_9) return key - GLFW_KEY_KP_0 + GLFW_KEY_0;
  if (key == GLFW_KEY_KP_ADD) return GLFW_KEY_EQUAL;
  return key == GLFW_KEY_KP_SUBTRACT ? GLFW_KEY_MINUS : key;
}

}  // namespace

std::span<const KeyCommand> key_commands() {
  static const std::vector<KeyCommand> kCommands = make_commands();
  return kCommands;
}

const KeyCommand* find_command(std::string_view help) {
  const std::span<const KeyCommand> rows = key_commands();
  const auto found = std::ranges::find(rows, help, &KeyCommand::help);
  return found == rows.end() ? nullptr : &*found;
}

std::string command_hint(std::string_view help) {
  const KeyCommand* found = find_command(help);
  if (found == nullptr) return std::string(help);
  return fmt::format("{} ({})", help, key_name(found->key, found->mods));
}

std::string menu_label(const KeyCommand& command) {
  return command.help + (command.opens_dialog ? " ..." : "");
}

bool has_words(const std::string& about, const std::string& text) {
  const auto lower = [](unsigned char c) { return std::tolower(c); };
  return std::ranges::all_of(separated(text, ' '), [&](const std::string& word) {
    return std::ranges::search(about, word, {}, lower, lower).begin() != about.end();
  });
}

std::vector<const KeyCommand*> find_commands(const std::string& text, const Viewer& viewer) {
  std::vector<const KeyCommand*> found;
  for (const KeyCommand& row : key_commands()) {
    if (row.menu == Menu::none || !(row.without_scene || viewer.scene)) continue;
    const std::string about = fmt::format("{} {} {}", kMenuNames[static_cast<int>(row.menu)],
                                          row.help, key_name(row.key, row.mods));
    if (has_words(about, text)) found.push_back(&row);
  }
  return found;
}

const KeyCommand* find_key_command(int key, int mods) {
  const int main_key = key_of_main_row(key);
  // Many keyboards have the plus sign above the equals sign.
  if (main_key == GLFW_KEY_EQUAL && mods == (kCtrl | kShift)) mods = kCtrl;
  const std::span<const KeyCommand> rows = key_commands();
  const auto keys = [](const KeyCommand& row) { return std::pair(row.key, row.mods); };
  const auto found = std::ranges::find(rows, std::pair(main_key, mods), keys);
  return found == rows.end() ? nullptr : &*found;
}

}  // namespace qs
