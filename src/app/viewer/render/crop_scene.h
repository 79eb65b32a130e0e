// SPDX-License-Identifier: MIT
//
// Shows a part of the scene in the window. The whole scene stays in RenderContext::cropped
// meanwhile.
#pragma once

#include "app/viewer/state/crop_actions.h"

namespace qs {

/// The cloud with the Gaussians to remove in a special colour, through which their old colour is
/// visible.
GaussianCloud tinted(GaussianCloud cloud, const Removal& removal);

/// Shows the scene as requested and reports crop_shown(). If that fails, the window keeps the old
/// scene, and crop_failed() is reported.
Job show_crop(const CropRequest& request);

namespace action {

/// Runs show_crop() if the window does not show wanted_crop() and no request is in progress.
void follow_crop(Viewer& viewer, Host& host);

}  // namespace action
}  // namespace qs
