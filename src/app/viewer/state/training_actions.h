// SPDX-License-Identifier: MIT
//
// Changes of Viewer::training, and the words of its panel.
#pragma once

#include "app/viewer/state/action.h"
#include "app/viewer/state/panel_text.h"

namespace qs {

/// True if the trainer works now. Then measurements would be wrong, and the picture is not final.
bool is_training(const Viewer& viewer);

/// True if a frame or an upload may begin: nothing is trained, or the budget allows it.
bool may_draw(const Viewer& viewer);

/// The facts of the panel; empty without training.
std::vector<Fact> training_facts(const Viewer& viewer);

/// The caption of the plot of Training::losses, which must not be empty: its axes.
std::string loss_plot_text(const Training& training);

namespace action {

// ---- by the user -------------------------------------------------------------------------------
/// Starts a run, unless a run is in progress.
void start_training(Viewer& viewer, Host& host, const TrainingRequest& request);
/// Passes the command to the host if it is valid in this phase.
void command_training(Viewer& viewer, Host& host, TrainingCommand command);
/// Pauses or resumes.
void toggle_training(Viewer& viewer, Host& host);

// ---- reports -----------------------------------------------------------------------------------
void training_began(Viewer& viewer, const std::filesystem::path& folder);
void training_progressed(Viewer& viewer, const TrainingProgress& progress);
void training_paused(Viewer& viewer, bool paused);
void training_ended(Viewer& viewer, const std::string& outcome, bool is_error);
/// Notes that the window now draws another model. Making and uploading it took `seconds`.
void model_shown(Viewer& viewer, int iteration, std::uint64_t gaussians, double seconds);

}  // namespace action
}  // namespace qs
