// SPDX-License-Identifier: MIT
#include "app/serve/sharing.h"

#include <utility>

#include "app/viewer/state/actions.h"
#include "app/viewer/state/crop_actions.h"
#include "app/viewer/state/edit_actions.h"

namespace qs {
namespace {

bool shows(const CropRequest& request, const Editing& editing) {
  return request.gone == editing.gone && request.pages == editing.pages;
}

}  // namespace

CropRequest Sharing::crop_of(std::size_t scene) {
  const Editing& editing = shared_[scene].editing;
  return {.gone = editing.gone, .steps = editing.steps, .pages = editing.pages};
}

void Sharing::follow_edits(Viewer& v, const Shared& shared) {
  v.editing = shared.editing;
  v.editing.waiting.clear();
  const bool marks = std::exchange(v.crop, {}).marks;
  v.crop.marks = marks;
  v.crop.asked = {
      .gone = shared.editing.gone, .steps = shared.editing.steps, .pages = shared.editing.pages};
  show_edits(v, shared.edits, shared.gaussians);
  const std::string text = edits_text(v);
  action::notify(v, text.empty() ? "another visitor undid the edits: the whole scene again"
                                 : "the scene is edited for all visitors: " + text);
}

bool Sharing::meet(Visitor& visitor, double now) {
  Shared& shared = shared_[visitor.scene()];
  const Viewer& v = visitor.viewer();
  // The scene shows the request that was carried out last. A request of the visitor that was
  // answered since the last meeting, or is not answered yet, is newer than the others'.
  const bool own_crop = v.crop.busy || v.editing.busy || v.crop.asked != visitor.met().asked;
  const bool own_backend = v.backend != visitor.met().backend;
  if (!own_crop && !shows(v.crop.asked, shared.editing))
    visitor.apply({[&](Viewer& viewer, Host&) { follow_edits(viewer, shared); }}, now);
  if (!own_backend && shared.backend && v.backend != *shared.backend) {
    const std::string name = kBackendNames[static_cast<int>(*shared.backend)];
    visitor.apply({call(action::backend_changed, *shared.backend),
                   call(action::notify, "another visitor chose the backend " + name + " for all")},
                  now);
  }
  bool has_changed = false;
  if (own_backend) {
    shared.backend = v.backend;
    has_changed = true;
  }
  if (!v.crop.busy && !v.editing.busy && !shows(v.crop.asked, shared.editing)) {
    shared.editing = v.editing;
    shared.gaussians = v.scene->gaussians;
    shared.edits = v.scene->edits;
    has_changed = true;
  }
  visitor.set_met({v.crop.busy ? visitor.met().asked : v.crop.asked, v.backend});
  return has_changed;
}

}  // namespace qs
