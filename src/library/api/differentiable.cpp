// SPDX-License-Identifier: MIT
//
// The differentiable rasterizer: both passes, and back; and the counts of the pixels that a frame's
// Gaussians contribute to.
#include <memory>

#include "library/api/passes.h"
#include "library/check/context.h"
#include "library/check/frame_memory.h"
#include "library/check/stage_arguments.h"
#include "library/check/structs.h"

using namespace qs::library;

namespace {

std::unique_ptr<Passes> passes_of(const StageCall& call, const Use& use) {
  return call.place.is_gpu() ? cuda_passes(call, use) : cpu_passes(call, use);
}

/// The derivatives by the pictures of a frame. Throws Error(usage).
QsBlended by_pictures_of(const StageCall& call, const QsBlended* given, const QsStageFrame& frame) {
  constexpr const char* kArgument = "by_pictures";
  const QsBlended by = blended_of(call, given, kArgument, Access::reads);
  const auto refuse_depth = [&](const QsArray& array, const char* name) {
    if (frame.has_depth == 0 && !is_absent(array))
      refuse(call.where(kArgument) / name, "is given, but the frame was drawn without depths");
  };
  refuse_depth(by.depth, "depth");
  refuse_depth(by.inverse_depth, "inverse_depth");
  return by;
}

}  // namespace

int32_t qs_project(QsContext* context, const QsInputs* inputs, const QsCamera* camera,
                   const QsRules* rules, const QsMemory* memory, const QsBoundary* boundary,
                   QsStageFrame* frame, char* message) {
  return library::call(__func__, message, [&](const char* function) {
    clear_frame(frame, {function, "frame"});
    require(context, {function, "context"});
    const StageCall call(function, inputs, camera, rules);
    const CallersMemory callers(call.where("memory"), memory);
    const QsBoundary wanted = boundary_of(call, boundary);
    const Use use(*context->context, {function, "context"});
    QsStageFrame made{};
    passes_of(call, use)->project(callers, wanted, made);
    write_struct(made, frame, {function, "frame"});
  });
}

int32_t qs_blend(QsContext* context, const QsInputs* inputs, const QsCamera* camera,
                 const QsRules* rules, const QsMemory* memory, const QsBlended* pictures,
                 QsStageFrame* frame, char* message) {
  return library::call(__func__, message, "context", context, [&](const char* function) {
    const StageCall call(function, inputs, camera, rules);
    const CallersMemory callers(call.where("memory"), memory);
    const QsBlended wanted = blended_of(call, pictures, "pictures", Access::writes);
    QsStageFrame drawn = frame_of(call, frame, false);
    const Use use(*context->context, {function, "context"});
    passes_of(call, use)->blend(callers, wanted, drawn);
    write_struct(drawn, frame, {function, "frame"});
  });
}

int32_t qs_forward(QsContext* context, const QsInputs* inputs, const QsCamera* camera,
                   const QsRules* rules, const QsMemory* memory, const QsBoundary* boundary,
                   const QsBlended* pictures, QsStageFrame* frame, char* message) {
  return library::call(__func__, message, [&](const char* function) {
    clear_frame(frame, {function, "frame"});
    require(context, {function, "context"});
    const StageCall call(function, inputs, camera, rules);
    const CallersMemory callers(call.where("memory"), memory);
    const QsBoundary wanted = boundary_of(call, boundary);
    const QsBlended wanted_pictures = blended_of(call, pictures, "pictures", Access::writes);
    const Use use(*context->context, {function, "context"});
    QsStageFrame made{};
    const auto passes = passes_of(call, use);
    passes->project(callers, wanted, made);
    passes->blend(callers, wanted_pictures, made);
    write_struct(made, frame, {function, "frame"});
  });
}

int32_t qs_blend_backward(QsContext* context, const QsInputs* inputs, const QsCamera* camera,
                          const QsRules* rules, const QsStageFrame* frame,
                          const QsBlended* by_pictures, const QsBoundaryGradients* by_boundary,
                          char* message) {
  return library::call(__func__, message, "context", context, [&](const char* function) {
    const StageCall call(function, inputs, camera, rules);
    const QsStageFrame given = frame_of(call, frame, true);
    const QsBlended by = by_pictures_of(call, by_pictures, given);
    const QsBoundaryGradients out = boundary_gradients_of(call, by_boundary, Access::writes);
    const Use use(*context->context, {function, "context"});
    const auto passes = passes_of(call, use);
    passes->blend_backward(given, by, out);
    if (out.ndc == 1) passes->to_ndc(out, call.view.camera);
  });
}

int32_t qs_project_backward(QsContext* context, const QsInputs* inputs, const QsCamera* camera,
                            const QsRules* rules, const QsStageFrame* frame,
                            const QsBoundaryGradients* by_boundary,
                            const QsInputGradients* by_inputs, char* message) {
  return library::call(__func__, message, "context", context, [&](const char* function) {
    const StageCall call(function, inputs, camera, rules);
    const QsStageFrame given = frame_of(call, frame, false);
    const QsBoundaryGradients by = boundary_gradients_of(call, by_boundary, Access::reads);
    const QsInputGradients out = input_gradients_of(call, by_inputs);
    const Use use(*context->context, {function, "context"});
    passes_of(call, use)->project_backward(given, by, out);
  });
}

int32_t qs_backward(QsContext* context, const QsInputs* inputs, const QsCamera* camera,
                    const QsRules* rules, const QsStageFrame* frame, const QsBlended* by_pictures,
                    const QsBoundaryGradients* by_boundary, const QsInputGradients* by_inputs,
                    char* message) {
  return library::call(__func__, message, "context", context, [&](const char* function) {
    const StageCall call(function, inputs, camera, rules);
    const QsStageFrame given = frame_of(call, frame, true);
    const QsBlended by = by_pictures_of(call, by_pictures, given);
    QsBoundaryGradients at_boundary{};
    if (by_boundary != nullptr)
      at_boundary = boundary_gradients_of(call, by_boundary, Access::writes);
    const QsInputGradients out = input_gradients_of(call, by_inputs);
    const Use use(*context->context, {function, "context"});
    const auto passes = passes_of(call, use);
    passes->backward(given, by, at_boundary, out);
    if (at_boundary.ndc == 1) passes->to_ndc(at_boundary, call.view.camera);
  });
}

int32_t qs_count_pixels(QsContext* context, const QsInputs* inputs, const QsCamera* camera,
                        const QsRules* rules, const QsStageFrame* frame, double behind,
                        const QsArray* counts, char* message) {
  return library::call(__func__, message, [&](const char* function) {
    require_all(function, {{"context", context}, {"counts", counts}});
    const StageCall call(function, inputs, camera, rules);
    const QsStageFrame given = frame_of(call, frame, false);
    if (!(behind >= 0 && behind < 1))
      refuse({function, "behind"}, "{} is not at least 0 and below 1", behind);
    check_array(*counts, {function, "counts"}, {call.gaussians}, 1u << QS_INT32, Access::writes,
                call.place);
    const Use use(*context->context, {function, "context"});
    passes_of(call, use)->count_pixels(given, behind, *counts);
  });
}
