// SPDX-License-Identifier: MIT
#include "app/viewer/state/first_view_actions.h"

#include "app/viewer/state/actions.h"
#include "app/viewer/state/camera_actions.h"
#include "io/camera/cameras.h"

namespace qs {

bool is_unknown(const Viewer& v, const ViewedScene& scene) {
  const std::string path = scene.path.string();
  return !v.last_views.contains(path) && !v.first_views.contains(path);
}

namespace action {

void offer_views(Viewer& v) {
  const bool offers = v.scene && v.scene->cameras.empty() && v.scene->candidates.size() > 1;
  v.view_choice = {offers};
}

void ask_for_views(Viewer& v) {
  if (!v.scene) return;
  offer_views(v);
  if (v.view_choice.wanted) return;
  notify(v, v.scene->cameras.empty()
                ? "this scene has no other views to choose from: Home goes to its first view"
                : "this scene starts at its first camera: [ and ] go to the others");
}

void candidates_drawn(Viewer& v, const std::filesystem::path& scene,
                      const std::shared_ptr<const Image>& pictures) {
  if (!v.view_choice.asked || !v.scene || v.scene->path != scene) return;
  v.view_choice = {};
  v.view_choice.pictures = pictures;
}

void choose_first_view(Viewer& v, Host& host, std::size_t index) {
  if (!v.scene || index >= v.scene->candidates.size() || !v.scene->cameras.empty()) return;
  v.view_choice = {};
  v.home = framed_camera(v.scene->candidates[index], v.camera.width, v.camera.height);
  v.first_views[v.scene->path.string()] = format_camera(v.home);
  go_home(v, host);
}

void close_view_choice(Viewer& v) { v.view_choice = {}; }

}  // namespace action
}  // namespace qs
