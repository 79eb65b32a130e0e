// SPDX-License-Identifier: MIT
#include "app/viewer/state/view_history.h"

#include <cmath>

#include <glm/geometric.hpp>

namespace qs {
namespace {

// Changes of the window's size round the lens.
constexpr double kRounding = 1e-9;

/// Focal length and offset of the principal point, in heights of the picture.
struct RelativeLens {
  double focal;
  glm::dvec2 offset;
};

RelativeLens relative_lens(const Camera& camera) {
  const glm::dvec2 middle = 0.5 * glm::dvec2(camera.width - 1, camera.height - 1);
  return {camera.focal_px.y / camera.height, (camera.center_px - middle) / double(camera.height)};
}

}  // namespace

bool same_view(const Camera& a, const Camera& b) {
  if (a.view_from_world != b.view_from_world || a.near_depth != b.near_depth) return false;
  const RelativeLens one = relative_lens(a), other = relative_lens(b);
  return std::abs(one.focal - other.focal) < kRounding * one.focal &&
         glm::distance(one.offset, other.offset) < kRounding;
}

void ViewHistory::keep(const PastView& view) {
  if (at < views.size() && same_view(views[at].camera, view.camera)) {
    views[at] = view;
    return;
  }
  if (!views.empty()) views.resize(at + 1);
  views.push_back(view);
  if (views.size() > kMostViews) views.pop_front();
  at = views.size() - 1;
}

const PastView* ViewHistory::back() { return at == 0 ? nullptr : &views[--at]; }

const PastView* ViewHistory::forward() { return at + 1 >= views.size() ? nullptr : &views[++at]; }

}  // namespace qs
