// SPDX-License-Identifier: MIT
// The differentiable rasterizer through the C interface with arrays on a GPU: the bits of
// learn/diff/cuda, small arrays on either side, and refusals.
#include <algorithm>
#include <functional>
#include <optional>
#include <utility>

#include <gmock/gmock.h>

#include "library/on_gpu.h"
#include "library/stage_drawing.h"
#include "support/gpu.h"
#include "support/gpu_stage_scenes.h"

namespace qs {
namespace {

using diff::DrawnView;
using test::Drawing;
using test::GpuMemory;
using test::GpuStageFrame;
using test::off_centre_view;
using test::OnGpu;
using test::PictureValues;
using test::stage_scene;
using test::StageScene;
using test::with_channels;

class CudaLibraryStages : public test::GpuTest {
 protected:
  void SetUp() override {
    GpuTest::SetUp();
    if (!IsSkipped()) context_.emplace(QS_BACKEND_CUDA, 0, 1);
  }
  quadsplat::Context& context() { return *context_; }

  /// The sentence of a forward pass.
  std::string refusal(Drawing<float>& drawing, std::int32_t code = QS_USAGE) {
    return test::sentence_of([&] { drawing.forward(context(), true); }, code);
  }

 private:
  std::optional<quadsplat::Context> context_;
};

/// Expects the bits of GpuStageFrame, in one call and in two, with the caller's temporary memory
/// and with the library's.
void expect_bits_of_the_stages(quadsplat::Context& context, const DrawnView& view,
                               const StageScene<float>& scene, bool with_depth = true) {
  GpuStageFrame frame;
  frame.with_depth = with_depth;
  const PictureValues<float> pictures = frame.draw(view, scene);
  auto weights = PictureValues<float>::random(view.camera, scene.channel_count);
  if (!with_depth) weights.depth = weights.inverse_depth = {};
  const std::vector<double> gradients = frame.gradients(view, scene, weights).numbers();
  for (const bool in_one_call : {true, false}) {
    OnGpu on_gpu;
    on_gpu.gives_temporary = on_gpu.keeps_small_arrays = in_one_call;
    Drawing<float> drawing(view, scene);
    drawing.placement = &on_gpu;
    drawing.with_depth = with_depth;
    drawing.forward(context, in_one_call);
    EXPECT_TRUE(drawing.pictures == pictures);
    EXPECT_EQ(drawing.frame.pairs, frame.frame.sizes.pairs);
    EXPECT_EQ(drawing.frame.memory, QS_MEMORY_CUDA);
    const auto found = drawing.backward(context, weights, true);
    EXPECT_EQ(found.numbers(), gradients);
    drawing.wants_boundary = false;
    auto alone = drawing.backward(context, weights, true);
    drawing.wants_boundary = true;
    alone.boundary = found.boundary;
    alone.by.channels = found.by.channels;
    EXPECT_EQ(alone.numbers(), gradients) << "without derivatives by the boundary";
    EXPECT_EQ(drawing.backward(context, weights, false).numbers(), gradients) << "a second time";
    EXPECT_EQ(on_gpu.asked_for_temporary > 0, in_one_call);
  }
}

TEST_F(CudaLibraryStages, have_the_bits_of_the_stages_for_inputs_of_all_kinds) {
  const DrawnView view = off_centre_view();
  StageScene<float> scene = stage_scene<float>(200, 31);
  expect_bits_of_the_stages(context(), view, scene);
  expect_bits_of_the_stages(context(), view, scene, false);
  scene.has_covariances = true;
  expect_bits_of_the_stages(context(), view, scene);
  expect_bits_of_the_stages(context(), view, with_channels(stage_scene<float>(60, 33), 3), false);
  for (const int channels : {1, 5, 32})
    expect_bits_of_the_stages(context(), view, with_channels(stage_scene<float>(60, 33), channels));
}

TEST_F(CudaLibraryStages, have_the_bits_of_the_stages_for_other_rules) {
  DrawnView view = off_centre_view();
  view.mode = default_mode();
  view.position.reset();
  view.rules.antialiased = true;
  view.rules.alpha_max = 0.9;
  view.rules.alpha_max_passes = false;
  view.rules.stops_at_equal = true;
  expect_bits_of_the_stages(context(), view, stage_scene<float>(150, 34));
}

TEST_F(CudaLibraryStages, draw_no_gaussians) {
  OnGpu on_gpu;
  Drawing<float> drawing(off_centre_view(), StageScene<float>());
  drawing.placement = &on_gpu;
  drawing.forward(context(), true);
  EXPECT_EQ(drawing.frame.pairs, 0u);
  EXPECT_EQ(drawing.pictures.color[0], drawing.background[0]);
  auto weights = PictureValues<float>::random(off_centre_view().camera, 3);
  const auto gradients = drawing.backward(context(), weights, true);
  double sum = 0;
  const auto pixels = weights.color.size() / 3;
  for (std::size_t i = 0; i < pixels; ++i) sum += static_cast<double>(weights.color[i]);
  EXPECT_NEAR(gradients.boundary.background[0], sum, 1e-3);
}

TEST_F(CudaLibraryStages, leave_the_elements_between_those_of_an_array) {
  const StageScene<float> scene = stage_scene<float>(40, 35);
  Drawing<float> drawing(off_centre_view(), scene), packed(off_centre_view(), scene);
  OnGpu on_gpu;
  packed.placement = drawing.placement = &on_gpu;
  std::vector<float> spaced(2 * 3 * scene.size(), 7), values(3);
  for (std::size_t i = 0; i < 3 * scene.size(); ++i) spaced[2 * i] = scene.means[i];
  for (std::int64_t& stride :
       {std::ref(drawing.inputs.means.strides[0]), std::ref(drawing.inputs.means.strides[1])})
    stride *= 2;
  drawing.inputs.means.data = spaced.data();
  // A background whose channels have one address.
  drawing.inputs.background.strides[0] = 0;
  std::fill(packed.background.begin(), packed.background.end(), drawing.background[0]);
  drawing.forward(context(), true);
  packed.forward(context(), true);
  EXPECT_TRUE(drawing.pictures == packed.pictures);
}

TEST_F(CudaLibraryStages, refuse_arrays_in_other_memory) {
  const DrawnView view = off_centre_view();
  const StageScene<float> scene = stage_scene<float>(40, 36);
  Drawing<float> drawing(view, scene);
  drawing.inputs.means.memory = QS_MEMORY_CUDA;
  EXPECT_EQ(refusal(drawing),
            "qs_forward: inputs.scales: is in host memory, but means is in the memory of GPU 0");
  drawing.inputs.means.memory = QS_MEMORY_HOST;
  drawing.inputs.opacities.memory = QS_MEMORY_CUDA;
  EXPECT_EQ(refusal(drawing),
            "qs_forward: inputs.opacities: is in the memory of GPU 0, but means is in host memory");

  // The memory of frames.
  class HostMemory : public test::Placement {
   public:
    OnGpu on_gpu;
    test::Blocks blocks;
    void place(QsArray& array) override { on_gpu.place(array); }
    void give_back() override { on_gpu.give_back(); }
    QsMemory memory() override { return blocks.memory(); }
  } host;
  Drawing<float> with_host_frame(view, scene);
  with_host_frame.placement = &host;
  QS_NEEDS_REAL_GPU("the emulator's memory is the host's");
  EXPECT_EQ(refusal(with_host_frame),
            "qs_forward: memory.allocate: returned memory that is not the GPU's");
}

TEST_F(CudaLibraryStages, refuse_frames_of_the_cpu_and_its_contexts) {
  const DrawnView view = off_centre_view();
  const StageScene<float> scene = stage_scene<float>(40, 37);
  OnGpu on_gpu;
  Drawing<float> drawing(view, scene), on_cpu(view, scene);
  drawing.placement = &on_gpu;
  drawing.forward(context(), true);
  on_cpu.forward(context(), true);  // arrays of the host are drawn by the CPU
  EXPECT_EQ(on_cpu.frame.memory, QS_MEMORY_HOST);
  std::swap(drawing.frame, on_cpu.frame);
  auto weights = PictureValues<float>::random(view.camera, 3);
  const auto refusal_of = [&](Drawing<float>& given) {
    return test::sentence_of([&] { given.backward(context(), weights, true); });
  };
  EXPECT_EQ(refusal_of(drawing),
            "qs_backward: frame: is in host memory, but the inputs are in the memory of GPU 0");
  EXPECT_EQ(refusal_of(on_cpu),
            "qs_backward: frame: is in the memory of GPU 0, but the inputs are in host memory");
  quadsplat::Context cpu = test::cpu();
  EXPECT_EQ(test::sentence_of([&] { drawing.forward(cpu, true); }),
            "qs_forward: inputs.means: is in the memory of GPU 0, but the context has the backend "
            "cpu: open one with QS_BACKEND_CUDA");
}

/// The counts of the pixels of a frame that qs_project() alone fills, in every second element.
/// `on_gpu` has the arrays; null: they stay on the host.
std::vector<std::int32_t> counts_of(quadsplat::Context& context, Drawing<float>& drawing,
                                    double behind, OnGpu* on_gpu) {
  const auto count = static_cast<std::int64_t>(drawing.scene.size());
  std::vector<std::int32_t> numbers(static_cast<std::size_t>(2 * count), -7);
  QsArray counts = quadsplat::array_of(numbers.data(), {count});
  counts.strides[0] = 2;
  QsInputs inputs = drawing.inputs;
  const QsMemory memory = on_gpu != nullptr ? on_gpu->memory() : drawing.blocks.memory();
  if (on_gpu != nullptr) {
    on_gpu->place(inputs);
    on_gpu->place(counts);
  }
  quadsplat::check(qs_project, context.get(), &inputs, &drawing.camera, &drawing.rules, &memory,
                   nullptr, &drawing.frame);
  for (int pass = 0; pass < 2; ++pass) {  // the second one overwrites the counts
    quadsplat::check(qs_count_pixels, context.get(), &inputs, &drawing.camera, &drawing.rules,
                     &drawing.frame, behind, &counts);
  }
  if (on_gpu != nullptr) on_gpu->give_back();
  return numbers;
}

/// Expects the counts of the CPU. Returns the largest one.
std::int32_t expect_counts_of_the_cpu(quadsplat::Context& context, const DrawnView& view,
                                      const StageScene<float>& scene, double behind) {
  OnGpu on_gpu;
  Drawing<float> drawing(view, scene), on_cpu(view, scene);
  const std::vector<std::int32_t> expected = counts_of(context, on_cpu, behind, nullptr);
  EXPECT_EQ(counts_of(context, drawing, behind, &on_gpu), expected) << behind;
  EXPECT_EQ(on_cpu.frame.memory, QS_MEMORY_HOST);
  EXPECT_EQ(drawing.frame.memory, QS_MEMORY_CUDA);
  return expected.empty() ? 0 : *std::max_element(expected.begin(), expected.end());
}

TEST_F(CudaLibraryStages, count_the_pixels_of_the_cpu) {
  DrawnView view = off_centre_view();
  for (const double behind : {0.0, 0.3, 0.5, 0.97}) {
    for (const unsigned seed : {41, 42, 43}) {
      EXPECT_GT(expect_counts_of_the_cpu(context(), view, stage_scene<float>(150, seed), behind),
                10);
    }
    // Lists of several segments.
    expect_counts_of_the_cpu(context(), view, stage_scene<float>(2000, 44), behind);
  }
  view.mode = default_mode();
  view.rules.antialiased = true;
  view.rules.alpha_max = 0.9;
  view.rules.stops_at_equal = true;
  expect_counts_of_the_cpu(context(), view, with_channels(stage_scene<float>(150, 45), 5), 0);
}

TEST_F(CudaLibraryStages, count_the_pixels_of_no_gaussians) {
  EXPECT_EQ(expect_counts_of_the_cpu(context(), off_centre_view(), StageScene<float>(), 0.5), 0);
}

TEST_F(CudaLibraryStages, refuse_to_count_pixels_in_other_memory) {
  OnGpu on_gpu;
  Drawing<float> drawing(off_centre_view(), stage_scene<float>(40, 37));
  drawing.placement = &on_gpu;
  drawing.forward(context(), true);
  QsInputs inputs = drawing.inputs;
  std::vector<std::int32_t> numbers(40, 7);
  const QsArray counts = quadsplat::array_of(numbers.data(), {40});
  const auto refusal = [&] {
    return test::sentence_of([&] {
      quadsplat::check(qs_count_pixels, context().get(), &inputs, &drawing.camera, &drawing.rules,
                       &drawing.frame, 0.5, &counts);
    });
  };
  EXPECT_EQ(refusal(),
            "qs_count_pixels: frame: is in the memory of GPU 0, but the inputs are in host memory");
  on_gpu.place(inputs);
  EXPECT_EQ(refusal(),
            "qs_count_pixels: counts: is in host memory, but means is in the memory of GPU 0");
  on_gpu.give_back();
  EXPECT_EQ(numbers, std::vector<std::int32_t>(40, 7));
}

TEST_F(CudaLibraryStages, refuse_double_precision) {
  OnGpu on_gpu;
  Drawing<double> drawing(off_centre_view(), stage_scene<double>(10, 38));
  drawing.placement = &on_gpu;
  EXPECT_EQ(test::sentence_of([&] { drawing.forward(context(), true); }),
            "qs_forward: inputs.means: has elements of type float64, which only the CPU computes");
}

TEST_F(CudaLibraryStages, end_with_a_sentence_without_memory) {
  OnGpu on_gpu;
  Drawing<float> drawing(off_centre_view(), stage_scene<float>(10, 38));
  class Refusing : public test::Placement {
   public:
    OnGpu on_gpu;
    void place(QsArray& array) override { on_gpu.place(array); }
    void give_back() override { on_gpu.give_back(); }
    QsMemory memory() override {
      QsMemory memory = on_gpu.memory();
      memory.allocate = [](void*, std::uint64_t, std::uint32_t) -> void* { return nullptr; };
      return memory;
    }
  } refusing;
  drawing.placement = &refusing;
  EXPECT_THAT(refusal(drawing, QS_DEVICE),
              testing::StartsWith("qs_forward: memory.allocate: returned null for "));
  EXPECT_EQ(drawing.frame.per_gaussian, nullptr);
}

}  // namespace
}  // namespace qs
