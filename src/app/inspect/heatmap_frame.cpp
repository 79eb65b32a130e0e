// SPDX-License-Identifier: MIT
#include "app/inspect/heatmap_frame.h"

#include "app/inspect/inspection.h"

namespace qs {

HeatmapMaker::HeatmapMaker(Renderer& renderer, const Camera& camera, const RenderSettings& settings,
                           HeatQuantity quantity, ThreadPool& pool, std::stop_token stop)
    : quantity_(quantity),
      size_(camera.width, camera.height),
      background_(settings.background),
      pool_(pool),
      stop_(std::move(stop)) {
  if (quantity != HeatQuantity::missed) return;
  RenderSettings baseline = settings;
  baseline.mode = kBaselineMode;
  Outputs outputs = inspection_outputs();
  outputs.color = false;
  baseline_ = renderer.render(camera, baseline, outputs, HostImage{}, stop_);
}

Outputs HeatmapMaker::outputs() const {
  return baseline_ ? inspection_outputs() : outputs_for(quantity_);
}

FrameHeatmap HeatmapMaker::map(const Frame& frame) const {
  if (!baseline_) return {make_heatmap(frame, quantity_, size_.x, size_.y), std::nullopt};
  MissedMap missed = missed_contributions(*baseline_, frame, size_, background_, pool_, stop_);
  Heatmap heatmap = missed_heatmap(missed);
  return {std::move(heatmap), std::move(missed)};
}

CullMode scale_mode(HeatQuantity quantity, CullMode baseline) {
  if (quantity != HeatQuantity::missed) return baseline;
  for (CullMode mode = 1; mode <= mode_count(); ++mode) {
    if (!row_of(mode).lossless && !row_of(mode).keeps_faint) return mode;
  }
  return baseline;
}

Scale scale_of_view(Renderer& renderer, const Camera& camera, RenderSettings settings,
                    HeatQuantity quantity, ThreadPool& pool, std::stop_token stop) {
  settings.mode = scale_mode(quantity, settings.mode);
  const HeatmapMaker maker(renderer, camera, settings, quantity, pool, stop);
  Outputs outputs = maker.outputs();
  outputs.color = false;
  const Frame& frame = renderer.render(camera, settings, outputs, HostImage{}, std::move(stop));
  return scale_for(maker.map(frame).heatmap.values);
}

HeatmapFrame render_with_heatmap(Renderer& renderer, const Camera& camera,
                                 const RenderSettings& settings, HeatQuantity quantity,
                                 ThreadPool& pool, std::stop_token stop) {
  const HeatmapMaker maker(renderer, camera, settings, quantity, pool, stop);
  const Frame& frame =
      renderer.render(camera, settings, maker.outputs(), HostImage{}, std::move(stop));
  return {maker.map(frame), frame};
}

}  // namespace qs
