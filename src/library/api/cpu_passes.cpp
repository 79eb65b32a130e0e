// SPDX-License-Identifier: MIT
//
// The passes of the differentiable rasterizer on the CPU.
#include <cstdint>
#include <vector>

#include "learn/diff/cpu/blend.h"
#include "learn/diff/cpu/project.h"
#include "learn/diff/gaussian_parts.h"
#include "library/api/passes.h"
#include "library/check/frame_memory.h"

namespace qs::library {
namespace {

using namespace cpu::diff;
using cpu::diff::sizes_of;

template <class Real>
class CpuPasses final : public Passes {
 public:
  CpuPasses(const StageCall& call, const Workers& workers)
      : call_(call), workers_(workers), background_(numbers_in<Real>(call.inputs.background)) {}

  void project(const CallersMemory& memory, const QsBoundary& boundary,
               QsStageFrame& frame) override {
    ProjectedFrame<Real> projected;
    cpu::diff::project<Real>(call_.view, inputs_of<Real>(call_), workers_, projected,
                             boundary_rows_of<Real>(boundary), radius_rows_of(boundary.radii));
    const HeldSizes sizes = sizes_of(projected, gaussians(), size());
    const auto held = memory.allocate<GaussianBlock<Real>>(sizes, QS_HELD_PER_GAUSSIAN);
    const auto pairs = memory.allocate<PairBlock>(sizes, QS_HELD_PER_PAIR);
    hold(projected, sizes, held, pairs);
    frame.type = call_.type();
    frame.gaussians = sizes.gaussians;
    frame.listed = sizes.slots;
    frame.pairs = sizes.pairs;
    frame.width = sizes.width;
    frame.height = sizes.height;
    frame.per_gaussian = held.header;
    frame.per_pair = pairs.header;
  }

  void blend(const CallersMemory& memory, const QsBlended& pictures, QsStageFrame& frame) override {
    const HeldFrame<Real> held(frame);
    HeldSizes sizes = held.sizes;
    sizes.channels = static_cast<std::uint32_t>(call_.channels);
    sizes.has_depth = is_absent(pictures.depth) && is_absent(pictures.inverse_depth) ? 0 : 1;
    const auto pixels = memory.allocate<PixelBlock<Real>>(sizes, QS_HELD_PER_PIXEL);
    *pixels.header = {PixelBlock<Real>::kMark, sizes};
    cpu::diff::blend<Real>(blend_input(), held.view(), workers_, pixels.state,
                           pictures_of<Real>(pictures));
    frame.channels = sizes.channels;
    frame.has_depth = sizes.has_depth;
    frame.per_pixel = pixels.header;
  }

  void blend_backward(const QsStageFrame& frame, const QsBlended& by,
                      const QsBoundaryGradients& out) override {
    blend_back(frame, by, out, boundary_rows_of<Real>(out));
  }
  void project_backward(const QsStageFrame& frame, const QsBoundaryGradients& by,
                        const QsInputGradients& out) override {
    project_back(frame, boundary_rows_of<const Real>(by), out);
  }
  void backward(const QsStageFrame& frame, const QsBlended& by,
                const QsBoundaryGradients& at_boundary, const QsInputGradients& out) override {
    // In the caller's arrays, else in arrays of its own.
    Boundary<Real> rows = boundary_rows_of<Real>(at_boundary);
    std::vector<std::vector<Real>> own;
    const auto complete = [&](Rows<Real>& missing, int numbers) {
      if (missing) return;
      own.emplace_back(gaussians() * static_cast<std::size_t>(numbers));
      missing = Rows<Real>::packed(own.back().data(), numbers);
    };
    complete(rows.mean_px, 2);
    complete(rows.conic, 3);
    complete(rows.depth, 1);
    complete(rows.opacity, 1);
    complete(rows.color, 3);
    blend_back(frame, by, at_boundary, rows);
    project_back(frame, rows, out);
  }
  void count_pixels(const QsStageFrame& frame, double behind, const QsArray& counts) override {
    cpu::diff::count_pixels<Real>(
        size(), call_.view.rules.pixel_rules<Real>(), HeldFrame<Real>(frame).view(), gaussians(),
        static_cast<Real>(behind), workers_, rows_of<std::int32_t>(counts));
  }
  void scale(const QsArray& rows, double x, double y) override {
    if (is_absent(rows)) return;
    workers_.pool.for_each(gaussians(), 4096,
                           diff::RowScale<Real>{rows_of<Real>(rows), static_cast<Real>(x),
                                                static_cast<Real>(y), rows.sizes[1] == 3});
  }

 private:
  std::size_t gaussians() const { return static_cast<std::size_t>(call_.gaussians); }
  PictureSize size() const { return {call_.view.camera.width, call_.view.camera.height}; }

  BlendInput<Real> blend_input() const {
    return {size(), call_.view.rules.pixel_rules<Real>(), static_cast<int>(call_.channels),
            rows_of<const Real>(call_.inputs.channels),
            background_.empty() ? nullptr : background_.data()};
  }

  void blend_back(const QsStageFrame& frame, const QsBlended& by, const QsBoundaryGradients& given,
                  const Boundary<Real>& boundary) const {
    const HeldFrame<Real> held(frame);
    std::vector<Real> by_background(static_cast<std::size_t>(call_.channels));
    PairScratch<Real> scratch;
    cpu::diff::blend_backward<Real>(
        blend_input(), held.view(), held.sizes.gaussians,
        block_at<PixelBlock<Real>>(frame.per_pixel, held.sizes).read_only(),
        pictures_of<const Real>(by), workers_, scratch,
        {boundary, rows_of<Real>(given.channels), rows_of<Real>(given.absolute_px),
         is_absent(given.background) ? nullptr : by_background.data()});
    store_numbers(given.background, [&](std::int64_t channel, std::int64_t) {
      return by_background[static_cast<std::size_t>(channel)];
    });
  }

  void project_back(const QsStageFrame& frame, const Boundary<const Real>& by,
                    const QsInputGradients& out) const {
    PoseGradient pose;
    cpu::diff::project_backward<Real>(call_.view, inputs_of<Real>(call_),
                                      HeldFrame<Real>(frame).projected(), by, workers_,
                                      input_rows_of<Real>(out), &pose);
    store_numbers(out.view_from_world, [&](std::int64_t row, std::int64_t column) {
      return pose.view_from_world[static_cast<int>(column)][static_cast<int>(row)];
    });
    store_numbers(out.position, [&](std::int64_t axis, std::int64_t) {
      return pose.position[static_cast<int>(axis)];
    });
  }

  const StageCall& call_;
  Workers workers_;
  std::vector<Real> background_;
};

}  // namespace

std::unique_ptr<Passes> cpu_passes(const StageCall& call, const Use& use) {
  const Workers workers{use.pool(), use.stop()};
  if (call.type() == QS_FLOAT64) return std::make_unique<CpuPasses<double>>(call, workers);
  return std::make_unique<CpuPasses<float>>(call, workers);
}

}  // namespace qs::library
