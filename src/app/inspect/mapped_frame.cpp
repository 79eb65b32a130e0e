// SPDX-License-Identifier: MIT
#include "app/inspect/mapped_frame.h"

#include "app/inspect/inspection.h"

namespace qs {

Frame judging_frame(Renderer& renderer, const Camera& camera, RenderSettings settings,
                    std::stop_token stop) {
  settings.mode = kJudgeMode;
  Outputs outputs;
  outputs.color = false;
  outputs.trace = true;
  return renderer.render(camera, settings, outputs, HostImage{}, std::move(stop));
}

MappedFrame draw_mapped(Renderer& renderer, const Camera& camera, const RenderSettings& settings,
                        HeatQuantity quantity, ThreadPool& pool, std::stop_token stop) {
  if (quantity != HeatQuantity::missed) {
    const Frame& frame =
        renderer.render(camera, settings, outputs_for(quantity), HostImage{}, std::move(stop));
    return {frame, make_heatmap(frame, quantity, camera.width, camera.height), std::nullopt};
  }
  const Frame judge = judging_frame(renderer, camera, settings, stop);
  const Frame& frame = renderer.render(camera, settings, inspection_outputs(), HostImage{}, stop);
  MissedMap missed = missed_contributions(judge, frame, {camera.width, camera.height},
                                          settings.background, pool, std::move(stop));
  Heatmap heatmap = missed_heatmap(missed);
  return {frame, std::move(heatmap), std::move(missed)};
}

}  // namespace qs
