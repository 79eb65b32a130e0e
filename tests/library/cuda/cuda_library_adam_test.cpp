// SPDX-License-Identifier: MIT
// A step of Adam through the C interface with arrays in the memory of a GPU.
#include <memory>
#include <random>
#include <vector>

#include <gmock/gmock.h>

#include "library/on_gpu.h"
#include "library/opened_scene.h"
#include "support/gpu.h"

namespace qs {
namespace {

using quadsplat::array_of;
using test::OnGpu;

constexpr std::int64_t kRows = 700;

/// A step of N x 4 x 3 values with random numbers. One gradient is infinite.
struct Step {
  std::vector<float> values, gradients, first, second;
  std::vector<std::uint8_t> visible;
  QsAdam adam = quadsplat::default_adam();

  explicit Step(bool is_strided) {
    std::mt19937 random(9);
    std::uniform_real_distribution<float> uniform(0.0f, 1.0f);
    for (auto* const numbers : {&values, &gradients, &first, &second}) {
      numbers->resize(static_cast<std::size_t>(kRows) * 12);
      for (float& number : *numbers) number = uniform(random);
    }
    gradients[17] = INFINITY;
    for (std::int64_t row = 0; row < kRows; ++row)
      visible.push_back(static_cast<std::uint8_t>(random() % 3));
    const auto array = [&](std::vector<float>& numbers) {
      QsArray made = array_of(numbers.data(), {kRows, 4, 3});
      if (is_strided) {  // in planes, the last row first
        made.data = numbers.data() + kRows - 1;
        made.strides[0] = -1;
        made.strides[1] = kRows;
        made.strides[2] = 4 * kRows;
      }
      return made;
    };
    adam.step = 3;
    adam.rate = 0.01;
    adam.values = array(values);
    adam.gradients = is_strided ? array_of(gradients.data(), {kRows, 4, 3}) : array(gradients);
    adam.first = array(first);
    adam.second = array(second);
    adam.visible = array_of(visible.data(), {kRows});
  }
  void place(OnGpu& on_gpu) {
    for (QsArray* const array :
         {&adam.values, &adam.gradients, &adam.first, &adam.second, &adam.visible})
      on_gpu.place(*array);
  }
};

class CudaLibraryAdam : public test::GpuTest {};

TEST_F(CudaLibraryAdam, has_the_bits_of_the_cpu) {
  quadsplat::Context context(QS_BACKEND_CUDA, 0, 1);
  for (const bool is_strided : {false, true}) {
    for (const bool all_are_visible : {false, true}) {
      Step expected(is_strided), found(is_strided);
      for (Step* const step : {&expected, &found})
        if (all_are_visible) step->adam.visible = QsArray{};
      context.step(expected.adam);
      OnGpu on_gpu;
      found.place(on_gpu);
      context.step(found.adam);
      on_gpu.give_back();
      EXPECT_EQ(found.values, expected.values);
      EXPECT_EQ(found.first, expected.first);
      EXPECT_EQ(found.second, expected.second);
      EXPECT_NE(found.values, Step(is_strided).values);
    }
  }
}

TEST_F(CudaLibraryAdam, of_several_arrays_has_the_bits_of_one_by_one) {
  quadsplat::Context context(QS_BACKEND_CUDA, 0, 1), cpu = test::cpu(1);
  constexpr std::size_t kArrays = 10;  // more than a launch has
  std::vector<std::unique_ptr<Step>> expected, found, on_host;
  OnGpu on_gpu;
  std::vector<QsAdam> steps, host_steps;
  for (std::size_t i = 0; i < kArrays; ++i) {
    for (auto* const list : {&expected, &found, &on_host}) {
      list->push_back(std::make_unique<Step>(i % 2 == 1));
      list->back()->adam.rate = 0.01 * static_cast<double>(i + 1);
      if (i % 3 == 0) list->back()->adam.visible = QsArray{};
    }
    context.step(expected[i]->adam);
    found[i]->place(on_gpu);
    steps.push_back(found[i]->adam);
    host_steps.push_back(on_host[i]->adam);
  }
  quadsplat::check(qs_adam_all, context.get(), steps.data(), kArrays);
  quadsplat::check(qs_adam_all, cpu.get(), host_steps.data(), kArrays);
  on_gpu.give_back();
  for (std::size_t i = 0; i < kArrays; ++i) {
    EXPECT_EQ(found[i]->values, expected[i]->values);
    EXPECT_EQ(found[i]->second, expected[i]->second);
    EXPECT_EQ(on_host[i]->values, expected[i]->values);
  }
  host_steps[3].rate = INFINITY;
  EXPECT_EQ(test::sentence_of(
                [&] { quadsplat::check(qs_adam_all, cpu.get(), host_steps.data(), kArrays); }),
            "qs_adam_all: steps[3].rate: is inf");
  EXPECT_EQ(on_host[0]->values, expected[0]->values) << "nothing changed";
  host_steps[3] = steps[3];
  EXPECT_EQ(test::sentence_of(
                [&] { quadsplat::check(qs_adam_all, cpu.get(), host_steps.data(), kArrays); }),
            "qs_adam_all: steps[3]: its arrays or its stream are in another place than the first "
            "step's");
}

TEST_F(CudaLibraryAdam, of_no_rows_does_nothing_and_other_places_are_refused) {
  quadsplat::Context context(QS_BACKEND_CUDA, 0, 1), cpu = test::cpu();
  Step step(false);
  OnGpu on_gpu;
  step.place(on_gpu);
  EXPECT_EQ(test::sentence_of([&] { cpu.step(step.adam); }),
            "qs_adam: adam.values: is in the memory of GPU 0, but the context has the backend cpu: "
            "open one with QS_BACKEND_CUDA");
  step.adam.visible.memory = QS_MEMORY_HOST;
  EXPECT_EQ(test::sentence_of([&] { context.step(step.adam); }),
            "qs_adam: adam.visible: is in host memory, but values is in the memory of GPU 0");
  step.adam.visible.memory = QS_MEMORY_CUDA;
  for (QsArray* const array : {&step.adam.values, &step.adam.gradients, &step.adam.first,
                               &step.adam.second, &step.adam.visible})
    array->sizes[0] = 0;
  context.step(step.adam);
  on_gpu.give_back();
  EXPECT_EQ(step.values, Step(false).values);
}

}  // namespace
}  // namespace qs
