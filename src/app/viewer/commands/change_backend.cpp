// SPDX-License-Identifier: MIT
//
// Uploads the scene to another backend and shows it from there.
#include "app/viewer/commands/jobs.h"
#include "app/viewer/render/upload_scene.h"

namespace qs {

void action::change_backend(Viewer& viewer, Host& host, Backend backend) {
  if (backend == viewer.backend) return;
  host.run([backend](RenderContext& context) {
    const auto end = hide_progress_at_end(context);
    Session& session = context.session;
    change_renderer(session, backend, [&](Backend wanted) {
      Progress progress = upload_progress(context, *session.scene);
      if (wanted == session.backend) progress.stop = {};  // the old renderer always comes back
      return upload_to(context, session.scene, wanted, progress);
    });
    context.report(action::backend_changed, backend);
  });
}

}  // namespace qs
