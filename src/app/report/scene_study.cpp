// SPDX-License-Identifier: MIT
#include <algorithm>

#include "app/measure/measure.h"
#include "app/measure/statistics.h"
#include "app/report/study_page.h"
#include "app/session/session.h"
#include "raster/kernel/cull/square.h"

namespace qs {
namespace {

double degrees(float radians) { return static_cast<double>(radians) * 180 / M_PI; }

constexpr GaussianQuantity kGaussianQuantities[] = {
    {"anisotropy",
     "anisotropy",
     "",
     "The longer axis of the ellipse divided by the shorter one: 1 is a disc, large values are "
     "needles.",
     {1, 1.25, 1.5, 1.75, 2, 2.5, 3, 4, 5, 7, 10, 20, 1e9},
     [](const Footprint& f, const Splat&) { return static_cast<double>(anisotropy_of(f)); }},
    {"tilt",
     "tilt",
     "degrees",
     "The angle between the longer axis and the nearest axis of the image: boxes fit best at 0 "
     "degrees, worst at 45.",
     {0, 3.75, 7.5, 11.25, 15, 18.75, 22.5, 26.25, 30, 33.75, 37.5, 41.25, 45},
     [](const Footprint& f, const Splat&) {
       const double angle = std::fmod(std::abs(degrees(tilt_of(f))), 90.0);
       return std::min(angle, 90 - angle);
     }},
    {"screen radius",
     "radius",
     "pixels",
     "Half of the longer axis of the ellipse inside which alpha exceeds 1/255.",
     {0, 2, 4, 6, 8, 12, 16, 24, 32, 48, 64, 128, 1e9},
     [](const Footprint& f, const Splat&) { return static_cast<double>(screen_radius_of(f)); }},
    {"opacity",
     "opacity",
     "",
     "Alpha at the centre of the Gaussian. Below 1/255 the Gaussian is invisible; above 0.35 its "
     "ellipse extends beyond three standard deviations.",
     {0, 1.0 / 255, 0.02, 0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.85, 1},
     [](const Footprint&, const Splat& s) { return static_cast<double>(s.opacity); }},
};

/// True if it is inside the image and has few enough tiles for a drawing.
bool is_drawable(const Footprint& footprint, const std::array<std::uint32_t, kCullerCount>& pairs,
                 glm::ivec2 size) {
  constexpr std::uint32_t kMostTiles = 120;
  const glm::vec2 half = glm::max(glm::vec2(Square::radius(footprint)), extents(footprint).max);
  const glm::vec2 low = footprint.mean_px - half, high = footprint.mean_px + half;
  return pairs[k3dgs - 1] <= kMostTiles && low.x > 0 && low.y > 0 &&
         high.x < static_cast<float>(size.x) && high.y < static_cast<float>(size.y);
}

void bin_gaussians(const Frame& frame, std::size_t view, glm::ivec2 size, SceneStudy& study) {
  const Trace& trace = frame.trace;
  for (std::size_t slot = 0; slot < trace.footprints.size(); ++slot) {
    const Footprint& footprint = trace.footprints[slot];
    std::array<std::uint32_t, kCullerCount> pairs{};
    for (CullMode mode = 1; mode <= kCullerCount; ++mode)
      pairs[static_cast<std::size_t>(mode - 1)] = count_mode_tiles(mode, footprint, frame.grid);
    for (std::size_t q = 0; q < study.binned.size(); ++q) {
      const std::size_t bin =
          bin_of(kGaussianQuantities[q], kGaussianQuantities[q].of(footprint, trace.splats[slot]));
      ++study.binned[q].gaussians[bin];
      for (std::size_t mode = 0; mode < pairs.size(); ++mode)
        study.binned[q].pairs[mode][bin] += pairs[mode];
    }
    const std::uint32_t adr = pairs[kAdr - 1], quad = pairs[kQuad - 1];
    if (adr > quad + study.example.saved && is_drawable(footprint, pairs, size))
      study.example = {view, trace.gaussians[slot], pairs, adr - quad};
  }
  study.visible += trace.gaussians.size();
}

void add_times(Renderer& renderer, const Camera& camera, RenderSettings settings,
               const std::stop_token& stop, SceneStudy& study) {
  const std::vector<CullMode> modes = all_modes();
  settings.tile_px = kTileSizes[kUsualSize];
  const MeasurePlan plan{.modes = modes, .frames = kStudyFrames, .progress = {{}, stop}};
  for (const ModeResult& result :
       measure_modes(renderer, camera, settings, {}, plan, [](CullMode, const Frame&) {})) {
    study.frame_ms[static_cast<std::size_t>(result.mode - 1)] +=
        median(result.frame_ms) / static_cast<double>(study.views);
  }
}

}  // namespace

std::span<const GaussianQuantity> quantities() { return kGaussianQuantities; }

std::size_t bin_of(const GaussianQuantity& quantity, double value) {
  const auto inner = std::span(quantity.edges).subspan(1, kBins - 1);
  return static_cast<std::size_t>(std::ranges::upper_bound(inner, value) - inner.begin());
}

SceneStudy study_scene(Renderer& cpu, std::span<const Camera> views, RenderSettings settings,
                       ThreadPool& pool, const Progress& progress) {
  SceneStudy study;
  study.views = views.size();
  study.binned.resize(std::size(kGaussianQuantities));
  const Outputs outputs{.color = false, .pairs = true, .trace = true};
  const std::size_t steps = views.size() * kTileSizes.size() * kCullerCount;
  std::size_t step = 0;
  for (std::size_t view = 0; view < views.size(); ++view) {
    const Camera& camera = views[view];
    add_times(cpu, camera, settings, progress.stop, study);
    for (std::size_t size = 0; size < kTileSizes.size(); ++size) {
      settings.tile_px = kTileSizes[size];
      const glm::ivec2 pixels(camera.width, camera.height);
      std::optional<PairUses> of_lossless;
      for (settings.mode = 1; settings.mode <= kCullerCount; ++settings.mode, ++step) {
        progress.update(static_cast<float>(step) / static_cast<float>(steps));
        const Frame& frame = cpu.render(camera, settings, outputs, HostImage{}, progress.stop);
        study.gaussians = frame.stats.gaussians;
        if (settings.mode == k3dgs && settings.tile_px == kTileSize)
          bin_gaussians(frame, view, pixels, study);
        // Lossless modes list the same pairs that reach a pixel, and draw the same picture. So they
        // differ only in the number of empty pairs, and only one lossless mode is examined.
        const bool lossless = row_of(settings.mode).lossless;
        PairUses uses = lossless && of_lossless
                            ? *of_lossless
                            : sum_up(pair_uses(frame, pixels, pool, progress.stop));
        if (lossless) of_lossless = uses;
        uses.empty = frame.stats.tile_pairs - uses.used - uses.hidden;
        ModeStudy& mode = study.modes[size][static_cast<std::size_t>(settings.mode - 1)];
        mode.pairs += frame.stats.tile_pairs;
        mode.uses.used += uses.used;
        mode.uses.hidden += uses.hidden;
        mode.uses.empty += uses.empty;
        mode.loads.insert(mode.loads.end(), frame.pairs.begin(), frame.pairs.end());
      }
    }
  }
  for (auto& size : study.modes)
    for (ModeStudy& mode : size) std::ranges::sort(mode.loads);
  progress.update(1);
  return study;
}

}  // namespace qs
