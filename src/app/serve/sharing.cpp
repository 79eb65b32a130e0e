// SPDX-License-Identifier: MIT
#include "app/serve/sharing.h"

#include <fmt/format.h>

#include "app/viewer/state/actions.h"
#include "base/text.h"

namespace qs {
namespace {

// The state of a viewer that shows these crops without a further request.
Crop crop_with(std::vector<CropWish> crops, const std::optional<RemovalCounts>& counts) {
  Crop crop;
  crop.marks = false;
  if (crops.empty()) return crop;
  crop.wish = crops.back();
  crops.pop_back();
  crop.done = std::move(crops);
  crop.applied = true;
  crop.asked = {crop.wish, CropView::rest, crop.done};
  crop.counts = counts;
  return crop;
}

}  // namespace

std::vector<CropWish> applied_crops(const CropRequest& request) {
  std::vector<CropWish> crops = request.done;
  if (request.view == CropView::rest && request.wish.removes()) crops.push_back(request.wish);
  return crops;
}

void Sharing::follow_crops(Viewer& v, const Shared& shared) {
  v.crop = crop_with(shared.crops, shared.counts);
  v.scene->gaussians = shared.gaussians;
  v.scene->edits = shared.edits;
  v.inspected.reset();
  action::view_changed(v);
  action::notify(v, shared.crops.empty()
                        ? std::string("another visitor undid the crop: the whole scene again")
                        : fmt::format("the scene is cropped for all visitors: {} Gaussians stay",
                                      grouped(shared.gaussians)));
}

CropRequest Sharing::crop_of(std::size_t scene) {
  return crop_with(shared_[scene].crops, std::nullopt).asked;
}

bool Sharing::meet(Visitor& visitor, double now) {
  Shared& shared = shared_[visitor.scene()];
  const Viewer& v = visitor.viewer();
  // The scene shows the request that was carried out last. A request of the visitor that was
  // answered since the last meeting, or is not answered yet, is newer than the others'.
  const bool own_crop = v.crop.busy || v.crop.asked != visitor.met().asked;
  const bool own_backend = v.backend != visitor.met().backend;
  if (!own_crop && applied_crops(v.crop.asked) != shared.crops)
    visitor.apply({[&](Viewer& viewer, Host&) { follow_crops(viewer, shared); }}, now);
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
  if (!v.crop.busy && applied_crops(v.crop.asked) != shared.crops) {
    shared.crops = applied_crops(v.crop.asked);
    shared.counts = v.crop.asked.view == CropView::rest ? v.crop.counts : std::nullopt;
    shared.gaussians = v.scene->gaussians;
    shared.edits = v.scene->edits;
    has_changed = true;
  }
  visitor.set_met({v.crop.busy ? visitor.met().asked : v.crop.asked, v.backend});
  return has_changed;
}

}  // namespace qs
