// SPDX-License-Identifier: MIT
//
// The passes of the differentiable rasterizer on the GPU of a context. Everything is enqueued in
// the caller's stream.
#include "library/api/passes.h"
#ifdef QUADSPLAT_HAVE_CUDA
#include <array>
#include <cstdint>
#include <vector>

#include "learn/diff/cuda/blend.h"
#include "learn/diff/cuda/device.h"
#include "learn/diff/cuda/gaussian_parts.h"
#include "learn/diff/cuda/project.h"
#include "library/check/gpu_arrays.h"
#include "library/check/gpu_memory.h"
#endif

namespace qs::library {
namespace {

#ifdef QUADSPLAT_HAVE_CUDA

namespace gpu = cuda::diff;

/// Calls f(i, address) for the elements of an array of up to two dimensions, row by row.
template <class F>
void for_each_element(const QsArray& array, std::size_t element_bytes, const F& f) {
  const std::int64_t columns = array.dimensions > 1 ? array.sizes[1] : 1;
  for (std::int64_t i = 0; i < array.sizes[0]; ++i)
    for (std::int64_t j = 0; j < columns; ++j)
      f(i * columns + j, static_cast<std::byte*>(array.data) +
                             offset_of(array, i, j) * static_cast<std::int64_t>(element_bytes));
}

class CudaPasses final : public Passes {
 public:
  CudaPasses(const StageCall& call, const Use& use)
      : call_(call),
        selected_(use.device()),
        queue_{call.inputs.stream, use.stop()},
        temporary_(call.where("inputs") / "temporary", call.inputs.temporary, queue_),
        view_(call.view) {
    const QsArray& position = call.inputs.position;
    if (is_absent(position) || position.memory == QS_MEMORY_HOST) return;
    const std::vector<double> at =
        numbers_in<double>(HostCopies(use, call.inputs.stream).of(position));
    view_.position = glm::dvec3(at[0], at[1], at[2]);
    view_.check(call.name);
  }

  void project(const CallersMemory& memory, const QsBoundary& boundary,
               QsStageFrame& frame) override {
    gpu::Frame made;
    made.sizes = gpu::GpuHeldSizes::of(view_.camera, static_cast<std::size_t>(call_.gaussians));
    made.gaussians =
        allocate_on_gpu(memory, gpu::bytes_of_gaussians(made.sizes), QS_HELD_PER_GAUSSIAN);
    void* const projected = temporary_.allocate(gpu::bytes_to_project(made.sizes));
    gpu::project(view_, inputs_of<float>(call_), queue_, projected, made,
                 boundary_rows_of<float>(boundary), radius_rows_of(boundary.radii));
    made.pairs = allocate_on_gpu(memory, gpu::bytes_of_pairs(made.sizes), QS_HELD_PER_PAIR);
    gpu::list(view_, queue_, projected, temporary_.allocate(gpu::bytes_to_list(made.sizes)), made);
    frame.type = call_.type();
    frame.gaussians = made.sizes.gaussians;
    frame.pairs = made.sizes.pairs;
    frame.width = made.sizes.width;
    frame.height = made.sizes.height;
    frame.per_gaussian = made.gaussians;
    frame.per_pair = made.pairs;
    frame.memory = call_.place.memory;
    frame.device = call_.place.device;
  }

  void blend(const CallersMemory& memory, const QsBlended& pictures, QsStageFrame& frame) override {
    gpu::Frame drawn = frame_on_gpu(frame);
    const bool with_depth = !is_absent(pictures.depth) || !is_absent(pictures.inverse_depth);
    const auto sizes = drawn.sizes.blended(static_cast<int>(call_.channels), with_depth);
    drawn.pixels = allocate_on_gpu(memory, gpu::bytes_of_pixels(sizes), QS_HELD_PER_PIXEL);
    gpu::blend(blend_input(), queue_, with_depth, drawn, pictures_of<float>(pictures));
    frame.channels = sizes.channels;
    frame.has_depth = with_depth ? 1 : 0;
    frame.per_pixel = drawn.pixels;
  }

  void blend_backward(const QsStageFrame& frame, const QsBlended& by,
                      const QsBoundaryGradients& out) override {
    blend_back(frame, by, out, boundary_rows_of<float>(out));
  }

  void project_backward(const QsStageFrame& frame, const QsBoundaryGradients& by,
                        const QsInputGradients& out) override {
    project_back_from(boundary_rows_of<const float>(by), frame, out);
  }

  void backward(const QsStageFrame& frame, const QsBlended& by,
                const QsBoundaryGradients& at_boundary, const QsInputGradients& out) override {
    auto rows = boundary_rows_of<float>(at_boundary);
    if (const gpu::Frame drawn = frame_on_gpu(frame); drawn.sizes.has_states) {
      const auto sums = gpu::sums_of_pixels(drawn, blend_back(frame, by, at_boundary, rows));
      project_back(frame, out, [&](void* scratch, diff::PoseGradient* pose) {
        gpu::project_backward_of_sums(view_, inputs_of<float>(call_), drawn, sums, queue_, scratch,
                                      input_rows_of<float>(out), pose);
      });
      return;
    }
    constexpr std::int64_t kNumbers = 2 + 3 + 1 + 1 + 3;  // a Gaussian's numbers in the boundary
    auto* next = temporary_.numbers<float>(static_cast<std::size_t>(call_.gaussians * kNumbers));
    const auto complete = [&](diff::Rows<float>& missing, int numbers) {
      if (!missing) missing = diff::Rows<float>::packed(next, numbers);
      if (next != nullptr) next += call_.gaussians * numbers;
    };
    complete(rows.mean_px, 2);
    complete(rows.conic, 3);
    complete(rows.depth, 1);
    complete(rows.opacity, 1);
    if (call_.has_sh()) complete(rows.color, 3);
    blend_back(frame, by, at_boundary, rows);
    project_back_from(rows, frame, out);
  }

  void count_pixels(const QsStageFrame& frame, double behind, const QsArray& counts) override {
    gpu::count_pixels(view_.rules.pixel_rules<float>(), frame_on_gpu(frame),
                      static_cast<float>(behind), queue_, rows_of<std::int32_t>(counts));
  }

  void scale(const QsArray& rows, double x, double y) override {
    if (is_absent(rows)) return;
    gpu::enqueue(diff::RowScale<float>{rows_of<float>(rows), static_cast<float>(x),
                                       static_cast<float>(y), rows.sizes[1] == 3},
                 static_cast<std::size_t>(call_.gaussians), queue_);
  }

 private:
  gpu::Frame frame_on_gpu(const QsStageFrame& frame) const {
    gpu::Frame result;
    result.sizes = gpu::GpuHeldSizes::of(view_.camera, static_cast<std::size_t>(call_.gaussians));
    result.sizes.pairs = static_cast<std::uint32_t>(frame.pairs);
    result.sizes = result.sizes.blended(static_cast<int>(frame.channels), frame.has_depth != 0);
    result.gaussians = frame.per_gaussian;
    result.pairs = frame.per_pair;
    result.pixels = frame.per_pixel;
    return result;
  }

  gpu::BlendInput blend_input() {
    return {{view_.camera.width, view_.camera.height},
            view_.rules.pixel_rules<float>(),
            static_cast<int>(call_.channels),
            rows_of<const float>(call_.inputs.channels),
            background()};
  }

  /// The numbers of the background one after the other; null if there is none.
  const float* background() {
    const QsArray& given = call_.inputs.background;
    if (is_absent(given)) return nullptr;
    if (given.memory == QS_MEMORY_HOST) {
      const std::vector<float> numbers = numbers_in<float>(given);
      auto* const copy = temporary_.numbers<float>(numbers.size());
      gpu::copy_to_gpu(copy, numbers.data(), numbers.size() * sizeof(float), queue_);
      return copy;
    }
    if (given.strides[0] == 1) return static_cast<const float*>(given.data);
    auto* const copy = temporary_.numbers<float>(static_cast<std::size_t>(given.sizes[0]));
    for_each_element(given, sizeof(float), [&](std::int64_t i, const std::byte* element) {
      gpu::copy_on_gpu(copy + i, element, sizeof(float), queue_);
    });
    return copy;
  }

  /// Returns the scratch memory of the pass.
  void* blend_back(const QsStageFrame& frame, const QsBlended& by, const QsBoundaryGradients& given,
                   const diff::Boundary<float>& rows) {
    const gpu::Frame drawn = frame_on_gpu(frame);
    float* const by_background =
        is_absent(given.background)
            ? nullptr
            : temporary_.numbers<float>(static_cast<std::size_t>(call_.channels));
    void* const scratch = temporary_.allocate(gpu::bytes_to_blend_backward(drawn.sizes));
    gpu::blend_backward(
        blend_input(), drawn, pictures_of<const float>(by), queue_, scratch,
        {rows, rows_of<float>(given.channels), rows_of<float>(given.absolute_px), by_background});
    if (by_background != nullptr) store(given.background, by_background);
    return scratch;
  }

  /// Stores numbers on the GPU in a small array of the caller, on the GPU or the host.
  void store(const QsArray& to, const float* numbers) {
    if (to.memory == QS_MEMORY_HOST) {
      std::vector<float> copy(static_cast<std::size_t>(to.sizes[0]));
      gpu::copy_from_gpu(copy.data(), numbers, copy.size() * sizeof(float), queue_);
      store_numbers(
          to, [&](std::int64_t i, std::int64_t) { return copy[static_cast<std::size_t>(i)]; });
      return;
    }
    for_each_element(to, sizeof(float), [&](std::int64_t i, std::byte* element) {
      gpu::copy_on_gpu(element, numbers + i, sizeof(float), queue_);
    });
  }

  void project_back_from(const diff::Boundary<const float>& by, const QsStageFrame& frame,
                         const QsInputGradients& out) {
    const gpu::Frame projected = frame_on_gpu(frame);
    project_back(frame, out, [&](void* scratch, diff::PoseGradient* pose) {
      gpu::project_backward(view_, inputs_of<float>(call_), projected, by, queue_, scratch,
                            input_rows_of<float>(out), pose);
    });
  }

  /// `pass` enqueues the backward pass of project() with scratch memory and the pose's place.
  template <class Pass>
  void project_back(const QsStageFrame& frame, const QsInputGradients& out, const Pass& pass) {
    const bool with_pose = !is_absent(out.view_from_world) || !is_absent(out.position);
    auto* const pose = with_pose ? temporary_.numbers<diff::PoseGradient>(1) : nullptr;
    pass(with_pose ? temporary_.allocate(gpu::bytes_of_pose(frame_on_gpu(frame).sizes)) : nullptr,
         pose);
    if (!with_pose) return;
    diff::PoseGradient found;
    gpu::copy_from_gpu(&found, pose, sizeof(found), queue_);
    store_found(out.view_from_world, [&](std::int64_t row, std::int64_t column) {
      return found.view_from_world[static_cast<int>(column)][static_cast<int>(row)];
    });
    store_found(out.position, [&](std::int64_t axis, std::int64_t) {
      return found.position[static_cast<int>(axis)];
    });
  }

  /// Stores value(i, j) in a small array of the caller, on the GPU or the host.
  template <class Value>
  void store_found(const QsArray& to, const Value& value) {
    if (is_absent(to)) return;
    if (to.memory == QS_MEMORY_HOST) {
      store_numbers(to, value);
      return;
    }
    const std::int64_t columns = to.dimensions > 1 ? to.sizes[1] : 1;
    with_type(to, [&](const auto* elements) {
      using Element = std::remove_cvref_t<decltype(*elements)>;
      for_each_element(to, sizeof(Element), [&](std::int64_t i, std::byte* element) {
        const auto number = static_cast<Element>(value(i / columns, i % columns));
        gpu::copy_to_gpu(element, &number, sizeof(number), queue_);
      });
    });
  }

  const StageCall& call_;
  gpu::SelectedGpu selected_;
  gpu::Queue queue_;
  Temporary temporary_;
  diff::DrawnView view_;
};

#endif

}  // namespace

std::unique_ptr<Passes> cuda_passes(const StageCall& call, const Use& use) {
  use.require_gpu(call.place.device, call.where("inputs") / "means");
#ifdef QUADSPLAT_HAVE_CUDA
  return std::make_unique<CudaPasses>(call, use);
#else
  fail(ErrorKind::device, "backend cuda: {}", gpu_report().problem);
#endif
}

}  // namespace qs::library
