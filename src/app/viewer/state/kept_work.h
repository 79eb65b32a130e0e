// SPDX-License-Identifier: MIT
//
// The user's work on a scene. Its keyframes are kept as views are, and come back when it is opened
// again; edit_actions.h keeps the edits. The question what to do with work that would be lost.
#pragma once

#include <string>
#include <vector>

#include "app/viewer/state/action.h"

namespace qs {

/// The name of a scene, as it was read, in the kept work.
std::string work_name(const ViewedScene& scene);

/// "3 keyframes and a crop and a film of which 31 % are drawn": what is lost if this file is opened
/// or, if it is empty, the window closes. Empty if nothing is lost.
std::string unsaved_text(const Viewer& viewer, const std::filesystem::path& opens);

namespace action {

/// Keeps the work on the scene in the window, and shows the work that was kept for it. Without
/// `another` the scene was read again and keeps its keyframes.
void keep_work(Viewer& viewer);
void restore_work(Viewer& viewer, bool another);

/// Opens a file or, without one, quits; asks first if that would lose something.
void leave(Viewer& viewer, Host& host, const std::filesystem::path& opens);
/// The same without a question. Stops a zoom or a film, and `keeps` it as far as it got.
void leave_now(Viewer& viewer, Host& host, const std::filesystem::path& opens, bool keeps);

}  // namespace action
}  // namespace qs
