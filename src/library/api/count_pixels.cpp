// SPDX-License-Identifier: MIT
//
// Counts of the pixels that a frame's Gaussians contribute to.
#include "learn/diff/cpu/count_pixels.h"

#include "library/check/context.h"
#include "library/check/frame_memory.h"
#include "library/check/stage_arguments.h"

using namespace qs::library;

namespace {

template <class Real>
void count_frame(const StageCall& call, const QsStageFrame& frame, double behind, const Use& use,
                 const QsArray& counts) {
  const cpu::diff::PictureSize size{call.view.camera.width, call.view.camera.height};
  cpu::diff::count_pixels<Real>(size, call.view.rules.pixel_rules<Real>(),
                                HeldFrame<Real>(frame).view(),
                                static_cast<std::size_t>(call.gaussians), static_cast<Real>(behind),
                                {use.pool(), use.stop()}, rows_of<std::int32_t>(counts));
}

}  // namespace

int32_t qs_count_pixels(QsContext* context, const QsInputs* inputs, const QsCamera* camera,
                        const QsRules* rules, const QsStageFrame* frame, double behind,
                        const QsArray* counts, char* message) {
  return library::call(__func__, message, [&](const char* function) {
    require_all(function, {{"context", context}, {"counts", counts}});
    const StageCall call(function, inputs, camera, rules);
    const QsStageFrame given = frame_of(call, frame, false);
    if (call.place.is_gpu())
      refuse({function, "frame"}, "is in {}, but pixels are counted in host memory alone",
             call.place.text());
    if (!(behind >= 0 && behind < 1))
      refuse({function, "behind"}, "{} is not at least 0 and below 1", behind);
    check_array(*counts, {function, "counts"}, {call.gaussians}, 1u << QS_INT32, Access::writes);
    const Use use(*context->context, {function, "context"});
    if (call.type() == QS_FLOAT64)
      count_frame<double>(call, given, behind, use, *counts);
    else
      count_frame<float>(call, given, behind, use, *counts);
  });
}
