// SPDX-License-Identifier: MIT
#include "app/session/surfaces.h"

#include <limits>
#include <utility>

#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>

#include "learn/lod/cut.h"

namespace qs {
namespace {

// A coarse cut has a quarter of the nodes, and its picture a quarter of the width (docs/lod.md).
constexpr int kCoarser = 4;

// In a flight the surfaces of a view serve as long as few nodes appear from behind them. They are
// found if they will serve so many cuts: a faster flight has cuts without.
constexpr double kServed = 4;

// True if the surfaces of one view serve the other. `distance`: of the surfaces.
bool is_near(const Camera& a, const Camera& b, double distance, double cuts = 1) {
  const double shift = 1 / (16 * cuts), turn = 0.25 / cuts;  // of the distance; radians
  const auto axis = [](const Camera& camera) {
    return glm::transpose(glm::dmat3(camera.view_from_world))[2];
  };
  return glm::distance(a.position(), b.position()) <= shift * distance &&
         glm::distance(axis(a), axis(b)) <= turn;
}

}  // namespace

SurfaceFinder::SurfaceFinder(ThreadPool& pool)
    : pool_(pool), renderer_(make_renderer(Backend::cpu, pool)) {}

StreamedCut SurfaceFinder::cut(LodView view, float smallest, const LodLimit& limit, double dilation,
                               bool moves, const MakeCut& make) {
  constexpr double kEndless = std::numeric_limits<double>::infinity();
  const double distance = last_ ? static_cast<double>(last_->distance()) : kEndless;
  const bool is_slow = is_near(seen_, view.camera, distance, kServed);
  seen_ = view.camera;
  const bool has_surfaces = view.camera.projection == Projection::pinhole && view.reach.angle == 0;
  if (has_surfaces && moves && last_ && is_near(last_camera_, view.camera, distance))
    view.surfaces = last_;
  else if (has_surfaces && (is_slow || !moves))
    view.surfaces = surfaces(view, smallest, limit, dilation, make);
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
  if (coarse.cut.limit == 0 || !coarse.cut.missing.empty()) return nullptr;
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
  last_ = std::make_shared<const LodSurfaces>(
      camera, renderer_->render(camera, settings, outputs).depth.median);
  last_camera_ = view.camera;
  return last_;
}

}  // namespace qs
