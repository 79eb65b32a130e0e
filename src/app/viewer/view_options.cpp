// SPDX-License-Identifier: MIT
#include "app/viewer/view_options.h"

#include <system_error>

#include "app/viewer/preferences.h"
#include "app/viewer/state/actions.h"
#include "base/fail.h"
#include "base/path_kind.h"

namespace qs {

bool first_start(const ViewOptions& options) {
  return !options.settings.empty() && !is_there(options.settings);
}

Viewer initial_viewer(const ViewOptions& options, glm::ivec2& window_size) {
  const FrameOptions& frame = options.frame;
  Viewer viewer;
  if (first_start(options)) viewer.hints = {true, true, true, true};
  const std::string problem = read_preferences(options.settings, viewer, window_size);
  if (!problem.empty()) action::notify_error(viewer, problem);
  if (frame.size) window_size = *frame.size;
  viewer.out_dir = options.out_dir;
  viewer.animates_moves = !options.script;
  viewer.restores_views = !frame.cameras;
  viewer.offers_views = !options.script;
  viewer.backend = frame.backend.value_or(available_backends().front());
  const CullMode kept = viewer.settings.mode;
  viewer.settings = frame.settings;
  viewer.settings.mode = frame.modes.empty() ? kept : frame.modes.front();
  if (viewer.settings.mode < 1 || viewer.settings.mode > mode_count())
    viewer.settings.mode = default_mode();
  viewer.keeps_work = !options.settings.empty();
  viewer.skips_huge = frame.skip_huge;
  viewer.settings.background = frame.background.value_or(glm::vec3(0));
  viewer.previous_mode = find_culler("3dgs");
  const auto other =
      find_variant(options.beside.value_or(mode_name(viewer.previous_mode)), viewer.variant());
  if (!other) fail(ErrorKind::usage, "view: --beside: there is no '{}' here", *options.beside);
  viewer.split.other = *other;
  viewer.vsync = viewer.vsync && options.vsync;
  viewer.panels.split = options.beside.has_value();
  if (options.train) viewer.training.emplace();
  if (options.connect) viewer.hints = {};
  return viewer;
}

}  // namespace qs
