// SPDX-License-Identifier: MIT
//
// Choosing the first view of a scene without cameras from pictures of a few candidates.
#pragma once

#include "app/viewer/state/action.h"

namespace qs {

/// True if the preferences know neither a last view nor a chosen first view of this scene.
bool is_unknown(const Viewer& viewer, const ViewedScene& scene);

namespace action {

/// Shows the strip of candidates as soon as the scene and then their pictures are drawn. No effect
/// if the scene has cameras or fewer than two candidates.
void offer_views(Viewer& viewer);

/// The same for the user who asks for it: says why there is no choice.
void ask_for_views(Viewer& viewer);

/// The pictures of the candidates of this scene file; ignored if nobody waits for them.
void candidates_drawn(Viewer& viewer, const std::filesystem::path& scene,
                      const std::shared_ptr<const Image>& pictures);

/// Goes to a candidate, which is the scene's first view from now on, and closes the strip. `index`
/// into ViewedScene::candidates.
void choose_first_view(Viewer& viewer, Host& host, std::size_t index);

void close_view_choice(Viewer& viewer);

}  // namespace action
}  // namespace qs
