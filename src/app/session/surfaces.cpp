// SPDX-License-Identifier: MIT
#include "app/session/surfaces.h"

#include <algorithm>
#include <utility>

#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>

#include "learn/lod/cut.h"

namespace qs {
namespace {

// A coarse cut has a quarter of the nodes, at most two for each pixel of its picture, which has a
// quarter of the width (docs/lod.md).
constexpr int kCoarser = 4;
constexpr std::size_t kNodesOfPixel = 2;
// A window shows the coarse cut itself while it lacks pages and has less than 1 / kFewer of the
// whole budget.
constexpr std::size_t kFewer = 16;

// A flight keeps the surfaces of a view until the camera has moved by kShift of their distance, or
// has turned by kTurn radians.
constexpr double kShift = 1.0 / 16, kTurn = 0.25;

// True if the surfaces of one view serve the other. `distance`: of the surfaces.
bool is_near(const Camera& a, const Camera& b, double distance) {
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
  if (view.camera.projection == Projection::pinhole && view.reach.angle == 0) {
    if (moves && last_ &&
        is_near(last_camera_, view.camera, static_cast<double>(last_->distance()))) {
      view.surfaces = last_;
    } else if (auto coarse = coarse_cut(view, smallest, limit, make)) {
      if (moves && !coarse->cut.missing.empty() && coarse->cut.count < limit.budget / kFewer)
        return *std::move(coarse);
      view.surfaces = surfaces_of(*coarse, view, dilation, moves);
    }
  }
  StreamedCut made = make(gain_in(view, smallest), limit, guess_);
  guess_ = made.cut.limit;
  return made;
}

std::shared_ptr<const LodSurfaces> SurfaceFinder::surfaces(const LodView& view, float smallest,
                                                           const LodLimit& limit, double dilation,
                                                           const MakeCut& make) {
  const auto coarse = coarse_cut(view, smallest, limit, make);
  return coarse ? surfaces_of(*coarse, view, dilation, false) : nullptr;
}

std::optional<StreamedCut> SurfaceFinder::coarse_cut(const LodView& view, float smallest,
                                                     const LodLimit& limit, const MakeCut& make) {
  if (limit.gain == 0 && limit.budget == LodLimit().budget) return std::nullopt;
  LodLimit part{limit.budget, kCoarser * limit.gain};
  if (limit.gain == 0) {
    const Camera camera = view.camera.reduced(kCoarser);
    const auto pixels =
        static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height);
    part.budget = std::min(part.budget / kCoarser, kNodesOfPixel * pixels);
  }
  StreamedCut coarse = make(gain_in(view, smallest), part, coarse_guess_);
  coarse_guess_ = coarse.cut.limit;
  if (coarse.cut.limit == 0 && coarse.cut.missing.empty()) return std::nullopt;
  return coarse;
}

std::shared_ptr<const LodSurfaces> SurfaceFinder::surfaces_of(const StreamedCut& coarse,
                                                              const LodView& view, double dilation,
                                                              bool moves) {
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
      camera, renderer_->render(camera, settings, outputs).depth.median,
      moves ? static_cast<float>(kShift * camera.focal_px.x) : 0.0f);
  last_ = coarse.cut.missing.empty() ? found : nullptr;
  last_camera_ = view.camera;
  return found;
}

}  // namespace qs
