// SPDX-License-Identifier: MIT
//
// Changes of the Viewer that panels, input, the command line or threads cause, apart from camera
// motion (camera_actions.h), the zoom recorder (zoom_actions.h) and background jobs
// (commands/jobs.h). Each is called through an Action (action.h). None of them waits, draws or
// reads a file. Changes that only a key or a menu causes are rows of commands/commands.cpp instead.
#pragma once

#include <string>
#include <variant>

#include "app/viewer/state/action.h"
#include "app/viewer/state/viewer.h"

namespace qs {

// ---- the result of opening a file --------------------------------------------------------------
// The opened scene, a sentence on why nothing was opened, or that it was cancelled.
// render/scene_opening.h owns the steps; Viewer::loading is their progress.

/// The scene that the render thread draws from now on.
struct OpenedScene {
  ViewedScene facts;
  RenderSettings settings;  ///< but for the mode, which stays the user's
  Backend backend = Backend::cpu;
};

/// Cameras for the scene in the window.
struct OpenedCameras {
  std::vector<Camera> cameras;
  std::filesystem::path file;
  std::map<int, std::filesystem::path> photographs;  ///< by index into `cameras`
  std::string warning = {};                          ///< about cameras that are left out; or empty
};

/// A camera path.
struct OpenedPath {
  std::vector<Keyframe> keyframes;
};

struct OpeningFailed {
  std::string sentence;
};

struct OpeningCancelled {
  std::string sentence;  ///< empty: nothing is said
};

using OpeningResult = std::variant<OpenedScene, SceneBeside, OpenedCameras, OpenedPath,
                                   OpeningFailed, OpeningCancelled>;

}  // namespace qs

namespace qs::action {

// ---- messages ----------------------------------------------------------------------------------
/// Shows a sentence for some seconds, errors for longer, and keeps it in the log.
void notify(Viewer& viewer, std::string text);
void notify_error(Viewer& viewer, std::string text);
/// Shows "wrote FILE" and `more`, with the absolute path of the file. The message stays longer, and
/// has buttons that open the file and copy its path.
void notify_file(Viewer& viewer, const std::filesystem::path& file, const std::string& more);
void dismiss_toast(Viewer& viewer, std::size_t index);
/// While they are held no messages disappear, and for a moment after.
void hold_toasts(Viewer& viewer, bool held);
void copy_text(Viewer& viewer, Host& host, const std::string& text);

// ---- picture -----------------------------------------------------------------------------------
/// A new frame is needed; view_changed(): also new numbers and a new comparison.
void picture_changed(Viewer& viewer);
void view_changed(Viewer& viewer);

void set_mode(Viewer& viewer, CullMode mode);
void peek_previous_mode(Viewer& viewer, bool held);
void change_split(Viewer& viewer, const Split& split);
void set_baseline(Viewer& viewer, CullMode mode);
void change_settings(Viewer& viewer, const RenderSettings& settings);
/// Shows the map of a quantity over the picture.
void show_heatmap(Viewer& viewer, HeatQuantity quantity);
/// Shows depth, alpha or the colours, without a heat map.
void show_quantity(Viewer& viewer, Quantity quantity);
void change_heat_view(Viewer& viewer, const HeatView& heat_view);

// ---- panels and switches -----------------------------------------------------------------------
void toggle_panel(Viewer& viewer, bool Panels::*panel);
void set_bar_width(Viewer& viewer, float Bars::*bar, float letters);
void toggle_option(Viewer& viewer, bool Viewer::*option);
void toggle_photograph(Viewer& viewer, Host& host);
void set_photograph_opacity(Viewer& viewer, float opacity);
void set_photograph_wipe(Viewer& viewer, float share);

// ---- files -------------------------------------------------------------------------------------
/// Opens a file, after a question if that would lose something (kept_work.h).
void open(Viewer& viewer, Host& host, const std::filesystem::path& path);
/// Opens or closes the dialog.
void toggle_open_dialog(Viewer& viewer, Choosing choosing);
/// Reads the scene again, with FrameOptions::skip_huge or without.
void skip_huge(Viewer& viewer, Host& host, bool skips);
/// Opens the path as the scene or as the second scene, or enters it into the dialog Train.
void path_chosen(Viewer& viewer, Host& host, const std::filesystem::path& path, Choosing choosing);
void cancel_loading(Viewer& viewer, Host& host);
/// Cancels the zoom, the film, the bench or the reading that runs.
void cancel_running(Viewer& viewer, Host& host);
/// Measured results of this name ("zoom") could not be written and stay in memory, or were written.
void results_kept(Viewer& viewer, const std::string& name, const std::string& reason);
void results_saved(Viewer& viewer);

// ---- camera path -------------------------------------------------------------------------------
void add_keyframe(Viewer& viewer);
void remove_keyframe(Viewer& viewer, std::size_t index);
void ease_keyframe(Viewer& viewer, std::size_t index, bool eases);
/// Moves a keyframe and all later keyframes in time, to `seconds` after the previous keyframe.
/// `index` > 0.
void delay_keyframe(Viewer& viewer, std::size_t index, double seconds);
void set_keyframes(Viewer& viewer, const std::vector<Keyframe>& keyframes);
/// Takes the last change of the keyframes in this scene `back`, or repeats it.
void step_keyframes(Viewer& viewer, bool back);
void toggle_playback(Viewer& viewer);
void seek(Viewer& viewer, double time);  ///< seconds on the path
/// Writes SCENE_path.json, in place of a path that was saved before. A file of another program
/// stays, and the path gets another name.
void save_keyframes(Viewer& viewer, Host& host);

// ---- reports of the loop and of threads --------------------------------------------------------
/// Begins a turn of the loop, `seconds` after the last turn.
void tick(Viewer& viewer, const Turn& turn, double seconds);

void show_progress(Viewer& viewer, const Loading& loading);
void end_progress(Viewer& viewer);
/// Shows the result of an opening. Viewer::loading may already be the progress of a newer opening.
void opening_ended(Viewer& viewer, Host& host, const OpeningResult& result);
void scene_opened(Viewer& viewer, Host& host, const OpenedScene& opened);
void beside_opened(Viewer& viewer, const SceneBeside& scene);
void cameras_opened(Viewer& viewer, Host& host, const OpenedCameras& opened);
void backend_changed(Viewer& viewer, Backend backend);
void photograph_opened(Viewer& viewer, const ShownPhotograph& photograph);
/// `quality` without a version: it was cancelled.
void photograph_compared(Viewer& viewer, const std::filesystem::path& photograph,
                         const PhotographQuality& quality);
/// A cut of the scene was made, see with_levels().
void levels_made(Viewer& viewer, const LevelFacts& facts);
void frame_shown(Viewer& viewer, const ShownFrame& frame);
void numbers_measured(Viewer& viewer, const ModeNumbers& numbers);
/// Adds frames to the numbers of the same view, unless these are complete.
void numbers_refined(Viewer& viewer, const ModeNumbers& more);
void pixel_inspected(Viewer& viewer, const InspectedView& view);
void compared_with_reference(Viewer& viewer, const ReferenceComparison& comparison);
void dismiss_comparison(Viewer& viewer);

}  // namespace qs::action
