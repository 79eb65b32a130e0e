// SPDX-License-Identifier: MIT
//
// Cuts that spare the nodes that nobody sees. A coarse cut, drawn on the CPU for every backend,
// shows the surfaces of a view; nodes behind them count less in the cut itself.
#pragma once

#include <functional>
#include <memory>
#include <optional>

#include "base/parallel.h"
#include "raster/api/renderer.h"
#include "raster/pages/page_stream.h"

namespace qs {

/// The variance of the renderer's filter, px^2; 0 if it keeps the light of each Gaussian.
inline double filter_of(const RenderSettings& settings, bool trained_antialiased) {
  return settings.antialiased.value_or(trained_antialiased) ? 0 : settings.dilation;
}

class SurfaceFinder {
 public:
  /// `pool` must outlive it.
  explicit SurfaceFinder(ThreadPool& pool);

  /// `guess`: see cut_of().
  using MakeCut =
      std::function<StreamedCut(const LodGain& gain, const LodLimit& limit, float guess)>;

  /// The cut of a view of a tree with this LodPages::footprint. `dilation`: see put_node(). Views
  /// through wide lenses and of parallel rays have no surfaces, and cuts of all leaves need none.
  /// `moves`: the view is one of a flight, so the surfaces of a view a little before serve too.
  StreamedCut cut(LodView view, float smallest, const LodLimit& limit, double dilation, bool moves,
                  const MakeCut& make);

  /// The surfaces that such a cut of a pinhole view knows; null if it has all leaves.
  std::shared_ptr<const LodSurfaces> surfaces(const LodView& view, float smallest,
                                              const LodLimit& limit, double dilation,
                                              const MakeCut& make);

 private:
  // None for cuts of all leaves.
  std::optional<StreamedCut> coarse_cut(const LodView& view, float smallest, const LodLimit& limit,
                                        const MakeCut& make);
  std::shared_ptr<const LodSurfaces> surfaces_of(const StreamedCut& coarse, const LodView& view,
                                                 double dilation, bool moves);

  ThreadPool& pool_;
  std::unique_ptr<Renderer> renderer_;
  float coarse_guess_ = 0, guess_ = 0;
  std::shared_ptr<const LodSurfaces> last_;  // of a cut with all its pages; null: none
  Camera last_camera_;
};

}  // namespace qs
