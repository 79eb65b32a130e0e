// SPDX-License-Identifier: MIT
//
// A step of Adam for the visible rows of an array, on the CPU or a GPU.
#include "learn/gradient/adam.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "library/check/arrays.h"
#include "library/check/context.h"
#include "library/check/structs.h"
#ifdef QUADSPLAT_HAVE_CUDA
#include "learn/diff/cuda/adam.h"
#include "learn/diff/cuda/device.h"
#endif

using namespace qs::library;

namespace {

/// Four dimensions, of which the array has the first.
using AdamShape = std::array<std::int64_t, 4>;

AdamShape check_adam(const QsAdam& adam, const Where& where) {
  if (adam.reserved != 0) refuse(where / "reserved", "is not 0");
  if (!std::isfinite(adam.rate)) refuse(where / "rate", "is {}", adam.rate);
  if (!(adam.beta1 >= 0 && adam.beta1 < 1))
    refuse(where / "beta1", "{} is not at least 0 and below 1", adam.beta1);
  if (!(adam.beta2 >= 0 && adam.beta2 < 1))
    refuse(where / "beta2", "{} is not at least 0 and below 1", adam.beta2);
  if (!(adam.epsilon >= 0 && std::isfinite(adam.epsilon)))
    refuse(where / "epsilon", "{} is not finite and at least 0", adam.epsilon);
  const QsArray& values = adam.values;
  const std::uint32_t dimensions = values.dimensions;
  if (dimensions < 1 || dimensions > 4)
    refuse(where / "values", "has {} dimensions instead of 1 to 4", dimensions);
  check_dimensions(values, where / "values", dimensions);
  AdamShape shape{1, 1, 1, 1};
  std::copy_n(values.sizes, dimensions, shape.begin());
  const Place place{values.memory, values.device, "values"};
  const auto check = [&](const QsArray& array, const char* name, Access access) {
    check_array(array, where / name, std::span<const std::int64_t>(shape).first(dimensions),
                kFloat32, access, place);
  };
  check(values, "values", Access::writes);
  check(adam.gradients, "gradients", Access::reads);
  check(adam.first, "first", Access::writes);
  check(adam.second, "second", Access::writes);
  if (!is_absent(adam.visible))
    check_array(adam.visible, where / "visible", {shape[0]}, kBytes, Access::reads, place);
  return shape;
}

bool is_visible(const QsAdam& adam, std::int64_t row) {
  return is_absent(adam.visible) ||
         static_cast<const std::uint8_t*>(adam.visible.data)[row * adam.visible.strides[0]] != 0;
}

/// Steps all values of a row.
void step_row(const QsAdam& adam, const AdamShape& shape, const AdamRule& rule,
              const AdamStep& step, std::int64_t row) {
  const auto element = [&](const QsArray& array, std::int64_t i, std::int64_t j,
                           std::int64_t k) -> float& {
    return static_cast<float*>(array.data)[offset_of(array, row, i, j, k)];
  };
  const auto rate = static_cast<float>(adam.rate);
  for (std::int64_t i = 0; i < shape[1]; ++i)
    for (std::int64_t j = 0; j < shape[2]; ++j)
      for (std::int64_t k = 0; k < shape[3]; ++k)
        qs::adam(rule, step, rate, element(adam.gradients, i, j, k), element(adam.values, i, j, k),
                 element(adam.first, i, j, k), element(adam.second, i, j, k));
}

/// A step of a call, checked.
struct CheckedStep {
  QsAdam adam;
  AdamShape shape;
  AdamRule rule;
  AdamStep step;
};

void step_on_host(const CheckedStep& given, const Use& use) {
  const auto& [adam, shape, rule, step] = given;
  use.pool().for_each(static_cast<std::size_t>(shape[0]), 1024, [&](std::size_t i) {
    const auto row = static_cast<std::int64_t>(i);
    if (is_visible(adam, row)) step_row(adam, shape, rule, step, row);
  });
}

#ifdef QUADSPLAT_HAVE_CUDA

namespace gpu = cuda::diff;

template <class T>
gpu::Elements<T> elements_of(const QsArray& array) {
  gpu::Elements<T> elements{static_cast<T*>(array.data), {}};
  std::copy_n(array.strides, array.dimensions, elements.strides);
  return elements;
}

gpu::AdamOrder order_of(const CheckedStep& given) {
  const QsAdam& adam = given.adam;
  gpu::AdamArrays arrays{{},
                         elements_of<const float>(adam.gradients),
                         elements_of<float>(adam.values),
                         elements_of<float>(adam.first),
                         elements_of<float>(adam.second),
                         static_cast<const std::uint8_t*>(adam.visible.data),
                         adam.visible.strides[0]};
  std::ranges::copy(given.shape, arrays.sizes);
  return {arrays, given.rule, given.step, static_cast<float>(adam.rate)};
}

void step_on_gpu(std::span<const CheckedStep> given, const Use& use) {
  std::vector<gpu::AdamOrder> orders;
  for (const CheckedStep& step : given) orders.push_back(order_of(step));
  const gpu::SelectedGpu selected(use.device());
  gpu::adam(orders, {given.front().adam.stream, use.stop()});
}

#else

void step_on_gpu(std::span<const CheckedStep>, const Use&) {}  // no context has a GPU

#endif

/// The steps of `count` > 0 structs, which are all checked first. `is_array`: sentences number
/// them.
void step_all(const char* function, library::Context& context, const QsAdam* steps,
              std::uint64_t count, bool is_array) {
  const Where all{function, is_array ? "steps" : "adam"};
  require(steps, all);
  std::vector<CheckedStep> checked;
  for (std::uint64_t i = 0; i < count; ++i) {
    Where where = all;
    if (is_array) where.index = static_cast<std::int64_t>(i);
    const QsAdam given = read_struct(element(steps, i, all), where);
    checked.push_back({given, check_adam(given, where),
                       AdamRule::of(given.beta1, given.beta2, given.epsilon),
                       given.step == 0 ? AdamStep{1, 1}
                                       : AdamStep::number(given.step, given.beta1, given.beta2)});
    const QsArray &first = checked.front().adam.values, &own = given.values;
    if (own.memory != first.memory || own.device != first.device ||
        given.stream != checked.front().adam.stream)
      refuse(where, "its arrays or its stream are in another place than the first step's");
  }
  const Use use(context, {function, "context"});
  const QsArray& values = checked.front().adam.values;
  if (values.memory == QS_MEMORY_CUDA) {
    use.require_gpu(values.device, {function, all.argument, is_array ? 0 : -1, "values"});
    step_on_gpu(checked, use);
    return;
  }
  for (const CheckedStep& step : checked) step_on_host(step, use);
}

}  // namespace

int32_t qs_adam(QsContext* context, const QsAdam* adam, char* message) {
  return library::call(__func__, message, "context", context, [&](const char* function) {
    step_all(function, *context->context, adam, 1, false);
  });
}

int32_t qs_adam_all(QsContext* context, const QsAdam* steps, uint64_t count, char* message) {
  return library::call(__func__, message, "context", context, [&](const char* function) {
    if (count > 0) step_all(function, *context->context, steps, count, true);
  });
}
