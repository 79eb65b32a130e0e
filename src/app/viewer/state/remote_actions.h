// SPDX-License-Identifier: MIT
//
// Changes of Viewer::remote, a training in another program, and the words of its panel.
#pragma once

#include <filesystem>
#include <vector>

#include "app/viewer/state/action.h"
#include "app/viewer/state/panel_text.h"

namespace qs {

/// The facts of the panel; empty without such a training.
std::vector<Fact> remote_facts(const Viewer& viewer);

/// "running", "paused", or why there are no pictures.
std::string remote_state(const RemoteRun& run);

/// Throws Error(usage) if the window shows a training in another program, so it has no scene to
/// draw or to change.
void require_scene(const Viewer& viewer);

namespace action {

/// Shows the training at `address` from now on. `cameras`: of its data set, may be empty.
void remote_opened(Viewer& viewer, Host& host, const std::string& address,
                   const std::vector<Camera>& cameras);
/// Takes the newest facts. A new problem is shown to the user.
void remote_reported(Viewer& viewer, const RemoteRun& run);

}  // namespace action
}  // namespace qs
