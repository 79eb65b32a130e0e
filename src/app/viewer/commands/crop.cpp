// SPDX-License-Identifier: MIT
//
// Writes the rest of a cropped scene to a new file, or sends it to a user at another machine.
#include <system_error>

#include <fmt/format.h>

#include "app/viewer/commands/jobs.h"
#include "app/viewer/commands/output_file.h"
#include "app/viewer/render/render_context.h"
#include "app/viewer/state/actions.h"
#include "app/viewer/state/kept_work.h"
#include "app/viewer/state/measure_actions.h"
#include "base/fail.h"
#include "base/text.h"
#include "io/bytes/replace_file.h"
#include "io/scene/writer.h"

namespace qs {
namespace {

// The rest of the scene. The key may be pressed before the window shows it.
std::shared_ptr<const GaussianCloud> demand_crop(const RenderContext& context,
                                                 const std::filesystem::path& path) {
  if (!context.session.gone)
    fail(ErrorKind::usage, "{}: the window does not show an edited scene, nothing was saved",
         path.string());
  return drawn_cloud(context.session);
}

void send(RenderContext& context, const Viewer& viewer) {
  const OutputFile output(viewer, "", viewer.scene->name + "_cropped", ".ply");
  const auto cloud = demand_crop(context, output.path().filename());
  const auto end = hide_progress_at_end(context);
  write_scene(*cloud, output.path(), *context.session.pool,
              shown_progress(output.path(), "writing", context.stop, context.reports));
  output.done(context, "");
}

void write(RenderContext& context, const std::filesystem::path& path) {
  const auto cloud = demand_crop(context, path);
  std::error_code error;
  if (std::filesystem::exists(std::filesystem::symlink_status(path, error)))
    fail(ErrorKind::usage, "{}: this file exists already: choose another name", path.string());
  const auto end = hide_progress_at_end(context);
  context.report(action::show_progress, Loading{path, "writing", 0});
  try {
    write_scene(*cloud, path, *context.session.pool,
                shown_progress(path, "writing", context.stop, context.reports));
    context.report(action::notify_file, path,
                   fmt::format(" ({})", counted(cloud->size(), "Gaussian")));
  } catch (const Cancelled&) {
    context.report(action::notify, std::string("writing was cancelled, nothing was saved"));
    throw;
  }
}

}  // namespace

void action::save_crop(Viewer& viewer, Host& host, const std::filesystem::path& name,
                       const Action& then) {
  if (!viewer.scene) return;
  if (viewer.editing.pages)
    return notify(viewer, "save the edits (Ctrl+S): quadsplat convert --edits writes a tree");
  if (!viewer.editing.gone)
    return notify(viewer, "nothing is cropped: apply a box or the search for floaters first");
  if (viewer.is_remote) return start_job(viewer, host, send);
  const std::filesystem::path folder = viewer.out_dir;
  const std::string stem = viewer.scene->name + "_cropped";
  host.run([=](RenderContext& context) {
    make_folder(folder);
    write(context, name.empty() ? free_name(folder, stem, ".ply") : folder / name);
    if (then) context.report(then);
  });
}

void action::save_and_leave(Viewer& viewer, Host& host, const std::filesystem::path& opens) {
  viewer.leaving.reset();
  if (opens.empty() && !viewer.unsaved_results.empty())
    return toggle_open_dialog(viewer, Choosing::results);
  Action then = call(leave_now, opens, true);
  if (measures_are_unsaved(viewer)) then = call(save_measures, then);
  if (!viewer.keeps_work) save_keyframes(viewer, host);
  if (viewer.keeps_work || !viewer.editing.gone) return then(viewer, host);
  save_crop(viewer, host, {}, then);
}

}  // namespace qs
