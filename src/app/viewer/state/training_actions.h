// SPDX-License-Identifier: MIT
//
// Changes of Viewer::training and of Viewer::remote, a training in another program, and the words
// of their panel.
#pragma once

#include <filesystem>
#include <vector>

#include "app/viewer/state/action.h"
#include "app/viewer/state/panel_text.h"

namespace qs {

/// True if the trainer works now. Then measurements would be wrong, and the picture is not final.
bool is_training(const Viewer& viewer);

/// True if a frame or an upload may begin: nothing is trained, or the budget allows it.
bool may_draw(const Viewer& viewer);

/// True if the scene in the window is the model of the run.
bool window_shows_model(const Viewer& viewer);

/// True if the renderers draw a part of the scene, or will after the job that runs.
bool shows_part_of_model(const Viewer& viewer);

/// The facts of the panel; empty without training.
std::vector<Fact> training_facts(const Viewer& viewer);

/// "test view view03 (1 of 3)", or the name of a training view, because no view is held out.
std::string test_view_title(const Training& training);

/// "PSNR 24.31 dB, SSIM 0.8412 at iteration 1,400", or the reason why there are no numbers yet.
/// `training.views` is set.
std::string test_view_text(const Viewer& viewer);

/// The facts of the panel; empty without such a training.
std::vector<Fact> remote_facts(const Viewer& viewer);

/// "running", "paused", or why there are no pictures.
std::string remote_state(const RemoteRun& run);

/// Throws Error(usage) if the window shows a training in another program, so it has no scene to
/// draw or to change.
void require_scene(const Viewer& viewer);

namespace action {

// ---- by the user -------------------------------------------------------------------------------
/// Starts a run, unless a run is in progress.
void start_training(Viewer& viewer, Host& host, const TrainingRequest& request);
/// Passes the command to the host if it is valid in this phase.
void command_training(Viewer& viewer, Host& host, TrainingCommand command);
/// Pauses or resumes.
void toggle_training(Viewer& viewer, Host& host);

/// Shows another test view, `by` places further in their list, which is a circle.
void step_test_view(Viewer& viewer, int by);

// ---- reports -----------------------------------------------------------------------------------
/// `views` may be null.
void training_began(Viewer& viewer, const std::filesystem::path& folder,
                    const std::shared_ptr<const TestViews>& views);
void training_progressed(Viewer& viewer, const TrainingProgress& progress);
void training_paused(Viewer& viewer, bool paused);
void training_ended(Viewer& viewer, const std::string& outcome, bool is_error);
/// `photograph` is of `view` of `views`; `shown`: for the panel. No effect if the panel shows
/// another view by now, as of the next two.
void test_photograph_read(Viewer& viewer, const std::shared_ptr<const TestViews>& views,
                          std::size_t view, const std::shared_ptr<const TestPhotograph>& photograph,
                          const std::shared_ptr<const Image>& shown);
void test_view_failed(Viewer& viewer, const std::shared_ptr<const TestViews>& views,
                      std::size_t view, const std::string& problem);
/// `seconds`: of drawing and comparing.
void test_view_compared(Viewer& viewer, const std::shared_ptr<const TestViews>& views,
                        const TestComparison& comparison, double seconds);
/// A comparison ended without a result.
void test_view_given_up(Viewer& viewer);
/// Notes that the window now draws another model. Making and uploading it took `seconds`.
void model_shown(Viewer& viewer, int iteration, std::uint64_t gaussians, double seconds);

/// Shows the training at `address` from now on. `cameras`: of its data set, may be empty.
void remote_opened(Viewer& viewer, Host& host, const std::string& address,
                   const std::vector<Camera>& cameras);
/// Takes the newest facts. A new problem is shown to the user.
void remote_reported(Viewer& viewer, const RemoteRun& run);

}  // namespace action
}  // namespace qs
