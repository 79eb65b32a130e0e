// SPDX-License-Identifier: MIT
#include "app/serve/served_scene.h"

#include "app/viewer/render/scene_reading.h"

namespace qs {

std::unique_ptr<ServedScene> open_served_scene(const FrameOptions& frame) {
  auto served = std::make_unique<ServedScene>();
  Session& session = served->context.session;
  session = open_session(frame);
  served->opened = {view_facts(*session.scene, frame.cameras, *session.pool, frame.up),
                    session.settings, session.backend};
  return served;
}

}  // namespace qs
