// SPDX-License-Identifier: MIT
//
// The edits of the scene in the window as steps: selections, crops, floaters, hiding and removing.
// The render thread carries out one step after the other; undoing and redoing is immediate.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "app/viewer/state/action.h"

namespace qs {

/// The steps that led to the scene in the window, and the steps that wait.
std::vector<EditStep> steps_of(const Viewer& viewer);

/// "488 of 500 Gaussians are left: 10 removed, 2 hidden"; empty if none is gone.
std::string edits_text(const Viewer& viewer);

/// SCENE.edits.json beside the scene. The window writes it after each step; if the selections are
/// large, once the user rests.
std::filesystem::path kept_edits_file(const std::filesystem::path& scene);
/// True if that file is not of the last step.
bool edits_are_to_keep(const Viewer& viewer);

namespace action {

/// Carries out a step, after the steps that wait.
void edit(Viewer& viewer, const EditStep& step);
/// Hides, shows, removes or keeps the selected Gaussians.
void edit_selected(Viewer& viewer, EditKind kind);

/// Takes the last change `back`, or repeats it: of the edits or of the keyframes, by whichever
/// changed last; a point while points are measured.
void step_back(Viewer& viewer, bool back);

/// Runs what the window does not show yet, else the step that waits, if nothing runs.
void follow_edits(Viewer& viewer, Host& host);

/// Writes the file beside the scene, then runs an action, which may be null.
void keep_edits(Viewer& viewer, Host& host, const Action& then);

/// Writes a file of edits.
void save_edits(Viewer& viewer, Host& host);
/// Replaces the edits by the edits of a file; `text`: its content, if it is not of this machine.
void open_edits(Viewer& viewer, Host& host, const std::filesystem::path& file,
                const std::optional<std::string>& text = {});
/// Offers the edits that kept_edits_file() has.
void offer_edits(Viewer& viewer);

// ---- reports of the render thread --------------------------------------------------------------
/// `after`: of the whole scene, not null.
void step_done(Viewer& viewer, const EditStep& step, const std::shared_ptr<const EditState>& after);
void step_failed(Viewer& viewer, const std::string& sentence);
void edits_saved(Viewer& viewer);
void edits_opened(Viewer& viewer, const std::filesystem::path& file, const EditHistory& history);
/// Beside the scene; `problem`: a sentence if they could not be, or "".
void edits_kept(Viewer& viewer, const std::string& problem);

}  // namespace action
}  // namespace qs
