// SPDX-License-Identifier: MIT
#include "app/measure/paper_times.h"

#include <cstddef>

#include "app/measure/measure_view.h"

namespace qs {

std::vector<std::vector<double>> paper_times(Session& session, const std::vector<CullMode>& modes,
                                             std::span<const Camera> views, int rounds,
                                             const Progress& progress) {
  std::vector<std::vector<double>> times(modes.size(), std::vector<double>(views.size()));
  if (views.empty()) return times;
  const Target target = bench_target(session.backend);
  const float runs = static_cast<float>(rounds) * static_cast<float>(modes.size());
  float done = 0;
  for (int round = 0; round < rounds; ++round) {
    for (std::size_t mode = 0; mode < modes.size(); ++mode) {
      progress.update(done++ / runs);
      RenderSettings settings = session.settings;
      settings.mode = modes[mode];
      const auto draw = [&](std::size_t view) {
        const Frame& frame =
            session.renderer->render(views[view], settings, {}, target, progress.stop);
        return static_cast<double>(frame.stats.frame_ms);
      };
      for (std::size_t i = 0; i < kPaperWarmupViews; ++i) draw(i % views.size());
      for (std::size_t view = 0; view < views.size(); ++view)
        times[mode][view] += draw(view) / rounds;
    }
  }
  return times;
}

}  // namespace qs
