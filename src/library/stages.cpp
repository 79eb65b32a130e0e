// SPDX-License-Identifier: MIT
//
// The differentiable rasterizer: both stages and their backward passes.
#include <cstdint>
#include <vector>

#include "library/context.h"
#include "library/frames.h"
#include "library/stage_arguments.h"
#include "library/structs.h"
#include "raster/cpu/stages/blend.h"
#include "raster/cpu/stages/project.h"

namespace qs::library {
namespace {

using cpu::stages::blend;
using cpu::stages::blend_backward;
using cpu::stages::BlendInput;
using cpu::stages::block_at;
using cpu::stages::Boundary;
using cpu::stages::GaussianBlock;
using cpu::stages::HeldSizes;
using cpu::stages::hold;
using cpu::stages::PairBlock;
using cpu::stages::PairScratch;
using cpu::stages::PictureSize;
using cpu::stages::PixelBlock;
using cpu::stages::PoseGradient;
using cpu::stages::project;
using cpu::stages::project_backward;
using cpu::stages::ProjectedFrame;
using cpu::stages::Rows;
using cpu::stages::sizes_of;
using cpu::stages::Workers;

/// Calls f<Real>() for QS_FLOAT32 or QS_FLOAT64.
template <class F>
void with_real(const StageCall& call, const F& f) {
  if (call.type() == QS_FLOAT64)
    f.template operator()<double>();
  else
    f.template operator()<float>();
}

PictureSize size_of(const StageCall& call) {
  return {call.view.camera.width, call.view.camera.height};
}

/// The inputs of blend(). It points to `background`.
template <class Real>
BlendInput<Real> blend_input(const StageCall& call, const std::vector<Real>& background) {
  BlendInput<Real> in;
  in.size = size_of(call);
  in.rules = call.view.rules.pixel_rules<Real>();
  in.channel_count = static_cast<int>(call.channels);
  in.channels = rows_of<const Real>(call.inputs.channels);
  in.background = background.empty() ? nullptr : background.data();
  return in;
}

// ---- forward

template <class Real>
void project_frame(const StageCall& call, const CallersMemory& memory, const QsBoundary& boundary,
                   const Workers& workers, QsStageFrame& frame) {
  ProjectedFrame<Real> projected;
  project<Real>(call.view, inputs_of<Real>(call), workers, projected,
                boundary_rows_of<Real>(boundary), rows_of<std::int32_t>(boundary.radii));
  const HeldSizes sizes =
      sizes_of(projected, static_cast<std::size_t>(call.gaussians), size_of(call));
  const auto gaussians = memory.allocate<GaussianBlock<Real>>(sizes, QS_HELD_PER_GAUSSIAN);
  const auto pairs = memory.allocate<PairBlock>(sizes, QS_HELD_PER_PAIR);
  hold(projected, sizes, gaussians, pairs);
  frame.type = call.type();
  frame.gaussians = sizes.gaussians;
  frame.listed = sizes.slots;
  frame.pairs = sizes.pairs;
  frame.width = sizes.width;
  frame.height = sizes.height;
  frame.per_gaussian = gaussians.header;
  frame.per_pair = pairs.header;
}

template <class Real>
void blend_frame(const StageCall& call, const CallersMemory& memory, const QsBlended& pictures,
                 const Workers& workers, QsStageFrame& frame) {
  const HeldFrame<Real> held(frame);
  HeldSizes sizes = held.sizes;
  sizes.channels = static_cast<std::uint32_t>(call.channels);
  sizes.has_depth = is_absent(pictures.depth) && is_absent(pictures.inverse_depth) ? 0 : 1;
  const auto pixels = memory.allocate<PixelBlock<Real>>(sizes, QS_HELD_PER_PIXEL);
  *pixels.header = {PixelBlock<Real>::kMark, sizes};
  const auto background = numbers_in<Real>(call.inputs.background);
  blend<Real>(blend_input(call, background), held.view(), workers, pixels.state,
              pictures_of<Real>(pictures));
  frame.channels = sizes.channels;
  frame.has_depth = sizes.has_depth;
  frame.per_pixel = pixels.header;
}

// ---- backward

/// The derivatives by the pictures of a frame. Throws Error(usage).
QsBlended by_pictures_of(const StageCall& call, const QsBlended* given, const QsStageFrame& frame) {
  constexpr const char* kArgument = "by_pictures";
  const QsBlended by = blended_of(call, given, kArgument, Access::reads);
  const auto refuse_depth = [&](const QsArray& array, const char* name) {
    if (frame.has_depth == 0 && !is_absent(array)) {
      refuse(call.where(kArgument) / name, "is given, but the frame was drawn without depths");
    }
  };
  refuse_depth(by.depth, "depth");
  refuse_depth(by.inverse_depth, "inverse_depth");
  return by;
}

template <class Real>
void blend_back(const StageCall& call, const QsStageFrame& frame, const QsBlended& by,
                const QsBoundaryGradients& given, const Workers& workers,
                const Boundary<Real>& boundary) {
  const HeldFrame<Real> held(frame);
  const auto background = numbers_in<Real>(call.inputs.background);
  std::vector<Real> by_background(static_cast<std::size_t>(call.channels));
  PairScratch<Real> scratch;
  blend_backward<Real>(blend_input(call, background), held.view(), held.sizes.gaussians,
                       block_at<PixelBlock<Real>>(frame.per_pixel, held.sizes).read_only(),
                       pictures_of<const Real>(by), workers, scratch,
                       {boundary, rows_of<Real>(given.channels), rows_of<Real>(given.absolute_px),
                        is_absent(given.background) ? nullptr : by_background.data()});
  store_numbers(given.background, [&](std::int64_t channel, std::int64_t) {
    return by_background[static_cast<std::size_t>(channel)];
  });
}

template <class Real>
void project_back(const StageCall& call, const QsStageFrame& frame, const Boundary<const Real>& by,
                  const Workers& workers, const QsInputGradients& out) {
  PoseGradient pose;
  project_backward<Real>(call.view, inputs_of<Real>(call), HeldFrame<Real>(frame).projected(), by,
                         workers, input_rows_of<Real>(out), &pose);
  store_numbers(out.view_from_world, [&](std::int64_t row, std::int64_t column) {
    return pose.view_from_world[static_cast<int>(column)][static_cast<int>(row)];
  });
  store_numbers(out.position, [&](std::int64_t axis, std::int64_t) {
    return pose.position[static_cast<int>(axis)];
  });
}

/// Derivatives by the boundary: in the caller's arrays, else in arrays of its own.
template <class Real>
class BoundaryStore {
 public:
  BoundaryStore(const QsBoundaryGradients& given, std::size_t gaussians)
      : rows_(boundary_rows_of<Real>(given)) {
    complete(rows_.mean_px, gaussians, 2);
    complete(rows_.conic, gaussians, 3);
    complete(rows_.depth, gaussians, 1);
    complete(rows_.opacity, gaussians, 1);
    complete(rows_.color, gaussians, 3);
  }
  const Boundary<Real>& rows() const { return rows_; }

 private:
  void complete(Rows<Real>& rows, std::size_t gaussians, int numbers) {
    if (rows) return;
    own_.emplace_back(gaussians * static_cast<std::size_t>(numbers));
    rows = Rows<Real>::packed(own_.back().data(), numbers);
  }

  Boundary<Real> rows_;
  std::vector<std::vector<Real>> own_;
};

}  // namespace
}  // namespace qs::library

using namespace qs;
using namespace qs::library;

int32_t qs_project(QsContext* context, const QsInputs* inputs, const QsCamera* camera,
                   const QsRules* rules, const QsMemory* memory, const QsBoundary* boundary,
                   QsStageFrame* frame, char* message) {
  return library::call(message, [&] {
    constexpr const char* kCall = "qs_project";
    clear_frame(frame, {kCall, "frame"});
    require(context, {kCall, "context"});
    const StageCall call(kCall, inputs, camera, rules);
    const CallersMemory callers(call, memory);
    const QsBoundary wanted = boundary_of(call, boundary);
    const Use use(*context->context, {kCall, "context"});
    QsStageFrame made{};
    with_real(call, [&]<class Real>() {
      project_frame<Real>(call, callers, wanted, {use.pool(), use.stop()}, made);
    });
    write_struct(made, frame, {kCall, "frame"});
  });
}

int32_t qs_blend(QsContext* context, const QsInputs* inputs, const QsCamera* camera,
                 const QsRules* rules, const QsMemory* memory, const QsBlended* pictures,
                 QsStageFrame* frame, char* message) {
  return library::call(message, [&] {
    constexpr const char* kCall = "qs_blend";
    require(context, {kCall, "context"});
    const StageCall call(kCall, inputs, camera, rules);
    const CallersMemory callers(call, memory);
    const QsBlended wanted = blended_of(call, pictures, "pictures", Access::writes);
    QsStageFrame drawn = frame_of(call, frame, false);
    const Use use(*context->context, {kCall, "context"});
    with_real(call, [&]<class Real>() {
      blend_frame<Real>(call, callers, wanted, {use.pool(), use.stop()}, drawn);
    });
    write_struct(drawn, frame, {kCall, "frame"});
  });
}

int32_t qs_forward(QsContext* context, const QsInputs* inputs, const QsCamera* camera,
                   const QsRules* rules, const QsMemory* memory, const QsBoundary* boundary,
                   const QsBlended* pictures, QsStageFrame* frame, char* message) {
  return library::call(message, [&] {
    constexpr const char* kCall = "qs_forward";
    clear_frame(frame, {kCall, "frame"});
    require(context, {kCall, "context"});
    const StageCall call(kCall, inputs, camera, rules);
    const CallersMemory callers(call, memory);
    const QsBoundary wanted = boundary_of(call, boundary);
    const QsBlended wanted_pictures = blended_of(call, pictures, "pictures", Access::writes);
    const Use use(*context->context, {kCall, "context"});
    const Workers workers{use.pool(), use.stop()};
    QsStageFrame made{};
    with_real(call, [&]<class Real>() {
      project_frame<Real>(call, callers, wanted, workers, made);
      blend_frame<Real>(call, callers, wanted_pictures, workers, made);
    });
    write_struct(made, frame, {kCall, "frame"});
  });
}

int32_t qs_blend_backward(QsContext* context, const QsInputs* inputs, const QsCamera* camera,
                          const QsRules* rules, const QsStageFrame* frame,
                          const QsBlended* by_pictures, const QsBoundaryGradients* by_boundary,
                          char* message) {
  return library::call(message, [&] {
    constexpr const char* kCall = "qs_blend_backward";
    require(context, {kCall, "context"});
    const StageCall call(kCall, inputs, camera, rules);
    const QsStageFrame given = frame_of(call, frame, true);
    const QsBlended by = by_pictures_of(call, by_pictures, given);
    const QsBoundaryGradients out = boundary_gradients_of(call, by_boundary, Access::writes);
    const Use use(*context->context, {kCall, "context"});
    with_real(call, [&]<class Real>() {
      blend_back<Real>(call, given, by, out, {use.pool(), use.stop()}, boundary_rows_of<Real>(out));
    });
  });
}

int32_t qs_project_backward(QsContext* context, const QsInputs* inputs, const QsCamera* camera,
                            const QsRules* rules, const QsStageFrame* frame,
                            const QsBoundaryGradients* by_boundary,
                            const QsInputGradients* by_inputs, char* message) {
  return library::call(message, [&] {
    constexpr const char* kCall = "qs_project_backward";
    require(context, {kCall, "context"});
    const StageCall call(kCall, inputs, camera, rules);
    const QsStageFrame given = frame_of(call, frame, false);
    const QsBoundaryGradients by = boundary_gradients_of(call, by_boundary, Access::reads);
    const QsInputGradients out = input_gradients_of(call, by_inputs);
    const Use use(*context->context, {kCall, "context"});
    with_real(call, [&]<class Real>() {
      project_back<Real>(call, given, boundary_rows_of<const Real>(by), {use.pool(), use.stop()},
                         out);
    });
  });
}

int32_t qs_backward(QsContext* context, const QsInputs* inputs, const QsCamera* camera,
                    const QsRules* rules, const QsStageFrame* frame, const QsBlended* by_pictures,
                    const QsBoundaryGradients* by_boundary, const QsInputGradients* by_inputs,
                    char* message) {
  return library::call(message, [&] {
    constexpr const char* kCall = "qs_backward";
    require(context, {kCall, "context"});
    const StageCall call(kCall, inputs, camera, rules);
    const QsStageFrame given = frame_of(call, frame, true);
    const QsBlended by = by_pictures_of(call, by_pictures, given);
    QsBoundaryGradients at_boundary{};
    if (by_boundary != nullptr)
      at_boundary = boundary_gradients_of(call, by_boundary, Access::writes);
    const QsInputGradients out = input_gradients_of(call, by_inputs);
    const Use use(*context->context, {kCall, "context"});
    const Workers workers{use.pool(), use.stop()};
    with_real(call, [&]<class Real>() {
      const BoundaryStore<Real> store(at_boundary, static_cast<std::size_t>(call.gaussians));
      blend_back<Real>(call, given, by, at_boundary, workers, store.rows());
      project_back<Real>(call, given, store.rows(), workers, out);
    });
  });
}
