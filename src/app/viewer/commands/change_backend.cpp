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
    session.second.reset();
    session.renderer =
        upload_to(context, session.scene, backend, upload_progress(context, *session.scene));
    session.backend = backend;
    context.report(action::backend_changed, backend);
  });
}

}  // namespace qs
