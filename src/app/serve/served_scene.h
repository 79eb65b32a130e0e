// SPDX-License-Identifier: MIT
//
// A scene of the server with its renderer. Visitors know it by its number only.
#pragma once

#include <map>
#include <memory>
#include <vector>

#include "app/session/session.h"
#include "app/viewer/render/render_context.h"
#include "app/viewer/state/actions.h"

namespace qs {

/// The renderers of a visitor of a scene with levels of detail.
struct OwnRenderers {
  Backend backend = Backend::cpu;
  std::unique_ptr<Renderer> renderer, second = {};  ///< as in Session
  bool in_use = false;                              ///< the session has them, and they are its own
};

struct ServedScene {
  OpenedScene opened;                           ///< the facts that visitors' viewers start with
  std::function<void()> reported = [] {};       ///< called on the renderer's thread after a report
  ActionQueue reports{[this] { reported(); }};  ///< of the job that runs
  std::map<int, OwnRenderers> own = {};         ///< by visitor, of the renderer's thread
  RenderContext context{reports, [](const FrameRequest&) {}};
};

using ServedScenes = std::vector<std::unique_ptr<ServedScene>>;

/// Reads and uploads a scene as open_session() does, and chooses its first view. Throws Error and
/// Cancelled.
std::unique_ptr<ServedScene> open_served_scene(const FrameOptions& frame);

}  // namespace qs
