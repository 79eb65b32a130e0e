// SPDX-License-Identifier: MIT
#include "raster/cpu/fast/pipeline.h"

#include "raster/cpu/common/stage_clock.h"

namespace qs::cpu::fast {

void FastPipeline::draw(const FrameContext& frame, const Outputs& outputs, Frame& result) {
  RenderStats& stats = result.stats;
  timed(Stage::preprocess, stats, [&] { preprocess(frame, scene_, outputs.trace, visible_); });
  timed(Stage::sort, stats, [&] { sort(frame, visible_, bands_); });
  timed(Stage::bin, stats, [&] { bin(frame, visible_, bands_, lists_); });
  if (outputs.color || outputs.evaluated) {
    timed(Stage::blend, stats, [&] { blend(frame, visible_, lists_, queue_, outputs, result); });
  }
  const auto splat_of = [&](std::uint32_t slot) {
    const Record& record = visible_.records[slot];
    return make_splat(visible_.footprints[slot], record.opacity(),
                      {record.red, record.green, record.blue});
  };
  collect(visible_, lists_, splat_of, outputs, result);
}

}  // namespace qs::cpu::fast
