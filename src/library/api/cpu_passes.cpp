// SPDX-License-Identifier: MIT
//
// The passes of the differentiable rasterizer on the CPU.
#include <cstdint>
#include <vector>

#include "learn/diff/cpu/blend.h"
#include "learn/diff/cpu/project.h"
#include "library/api/passes.h"
#include "library/check/frame_memory.h"

namespace qs::library {
namespace {

using namespace cpu::diff;
using cpu::diff::sizes_of;

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

template <class Real>
class CpuPasses final : public Passes {
 public:
  CpuPasses(const StageCall& call, const Workers& workers) : call_(call), workers_(workers) {}

  void project(const CallersMemory& memory, const QsBoundary& boundary,
               QsStageFrame& frame) override {
    project_frame<Real>(call_, memory, boundary, workers_, frame);
  }
  void blend(const CallersMemory& memory, const QsBlended& pictures, QsStageFrame& frame) override {
    blend_frame<Real>(call_, memory, pictures, workers_, frame);
  }
  void blend_backward(const QsStageFrame& frame, const QsBlended& by,
                      const QsBoundaryGradients& out) override {
    blend_back<Real>(call_, frame, by, out, workers_, boundary_rows_of<Real>(out));
  }
  void project_backward(const QsStageFrame& frame, const QsBoundaryGradients& by,
                        const QsInputGradients& out) override {
    project_back<Real>(call_, frame, boundary_rows_of<const Real>(by), workers_, out);
  }
  void backward(const QsStageFrame& frame, const QsBlended& by,
                const QsBoundaryGradients& at_boundary, const QsInputGradients& out) override {
    const BoundaryStore<Real> store(at_boundary, static_cast<std::size_t>(call_.gaussians));
    blend_back<Real>(call_, frame, by, at_boundary, workers_, store.rows());
    project_back<Real>(call_, frame, store.rows(), workers_, out);
  }

 private:
  const StageCall& call_;
  Workers workers_;
};

}  // namespace

std::unique_ptr<Passes> cpu_passes(const StageCall& call, const Use& use) {
  const Workers workers{use.pool(), use.stop()};
  if (call.type() == QS_FLOAT64) return std::make_unique<CpuPasses<double>>(call, workers);
  return std::make_unique<CpuPasses<float>>(call, workers);
}

}  // namespace qs::library
