// SPDX-License-Identifier: MIT
//
// The photograph beside the model's picture in the panel Training: reading on a thread, drawing and
// comparing on the render thread, behind the frames of the window.
#pragma once

#include "app/viewer/render/photograph_reader.h"
#include "app/viewer/state/training_actions.h"

namespace qs {

/// The picture with its longest side reduced to kTestPictureSide pixels.
std::shared_ptr<const Image> shown_in_panel(const Image& picture, ThreadPool& pool);

/// Reads the photograph of a view and reports test_photograph_read() or test_view_failed().
PhotographReader::Work read_test_photograph(const std::shared_ptr<const TestViews>& views,
                                            std::size_t view);

/// Draws the model in the window from the camera of the view that the panel shows, and reports
/// test_view_compared(). Reports test_view_given_up() if it was cancelled, or if the render thread
/// has another scene than the whole model. `training` has the view's photograph.
Job compare_test_view(const Training& training);

/// True if the panel will show another photograph or another comparison, without the user.
bool test_view_is_pending(const Viewer& viewer);

namespace action {

/// Asks for what the panel lacks while it is open: the photograph of its view, then a comparison,
/// at once for another view, and every kTestViewSeconds while the model is trained. Nothing is
/// compared while the camera moves.
void follow_test_view(Viewer& viewer, Host& host);

}  // namespace action
}  // namespace qs
