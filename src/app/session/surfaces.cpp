// SPDX-License-Identifier: MIT
#include "app/session/surfaces.h"

#include <utility>

#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>

#include "learn/lod/cut.h"

namespace qs {
namespace {

// A coarse cut has a quarter of the nodes, and its picture a quarter of the width (docs/lod.md).
constexpr int kCoarser = 4;

// True if few nodes appear from behind the surfaces of the other view. `distance`: of these.
bool is_near(const Camera& a, const Camera& b, double distance) {
  constexpr double kShift = 1.0 / 16, kTurn = 0.25;  // of the distance; radians
  const auto axis = [](const Camera& camera) {
    return glm::transpose(glm::dmat3(camera.view_from_world))[2];
  };
  return glm::distance(a.position(), b.position()) <= kShift * distance &&
         glm::distance(axis(a), axis(b)) <= kTurn;
}

}  // namespace

SurfaceFinder::SurfaceFinder(ThreadPool& pool)
    : pool_(pool), renderer_(make_renderer(Backend::cpu, pool)) {}

StreamedCut SurfaceFinder::cut(LodView view, float smallest, const LodLimit& limit, double dilation,
                               bool moves, const MakeCut& make) {
  if (view.camera.projection == Projection::pinhole && view.reach.angle == 0)
    view.surfaces = moves && last_ && is_near(last_camera_, view.camera, last_->distance())
                        ? last_
                        : surfaces(view, smallest, limit, dilation, make);
  StreamedCut made = make(gain_in(view, smallest), limit, guess_);
  guess_ = made.cut.limit;
  return made;
}

std::shared_ptr<const LodSurfaces> SurfaceFinder::surfaces(const LodView& view, float smallest,
                                                           const LodLimit& limit, double dilation,
                                                           const MakeCut& make) {
  if (limit.gain == 0 && limit.budget == LodLimit().budget) return nullptr;
  LodLimit part{limit.budget, kCoarser * limit.gain};
  if (limit.gain == 0) part.budget /= kCoarser;
  const StreamedCut coarse = make(gain_in(view, smallest), part, coarse_guess_);
  coarse_guess_ = coarse.cut.limit;
  if (coarse.cut.limit == 0) return nullptr;
  RenderSettings settings;
  settings.antialiased = dilation == 0;
  if (dilation > 0) settings.dilation = dilation;
  settings.dilation /= kCoarser * kCoarser;
  Outputs outputs;
  outputs.color = false;
  outputs.depth = true;
  const Camera camera = view.camera.reduced(kCoarser);
  // Without a filter: nodes fitted to the view's filter take five times as long.
  renderer_->upload(cut_cloud(coarse.tree, coarse.cut, view, 0, pool_, nullptr, 0), {});
  auto found = std::make_shared<const LodSurfaces>(
      camera, renderer_->render(camera, settings, outputs).depth.median);
  last_ = coarse.cut.missing.empty() ? found : nullptr;
  last_camera_ = view.camera;
  return found;
}

}  // namespace qs
