// SPDX-License-Identifier: MIT
//
// Parts of a trainer that compute every Gaussian for itself: the copies that replace it, its
// covariance, and its noise.
#include "learn/diff/gaussian_parts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "library/check/arrays.h"
#include "library/check/context.h"
#include "library/check/stage_arguments.h"
#include "library/check/structs.h"
#ifdef QUADSPLAT_HAVE_CUDA
#include "learn/diff/cuda/device.h"
#include "learn/diff/cuda/gaussian_parts.h"
#endif

using namespace qs::library;

namespace {

static_assert(QS_MOST_COPIES == kMostCopies);

/// The arrays of qs_relocate(), checked.
struct RelocationArrays {
  const QsArray &opacities, &scales, &counts, &new_opacities, &new_scales;

  Place place() const { return {opacities.memory, opacities.device, "opacities"}; }
};

/// Returns the number of Gaussians. Throws Error(usage).
std::int64_t check_relocation(const RelocationArrays& given) {
  constexpr const char* kCall = "qs_relocate";
  check_dimensions(given.opacities, {kCall, "opacities"}, 1);
  const std::int64_t count = given.opacities.sizes[0];
  if (count > kMostGaussians) refuse({kCall, "opacities"}, "{} Gaussians are too many", count);
  const Types reals = given.place().is_gpu() ? kFloat32 : kReals;
  const auto check = [&](const QsArray& array, const char* name,
                         std::initializer_list<std::int64_t> sizes, Types types, Access access) {
    check_array(array, {kCall, name}, sizes, types, access, given.place());
  };
  check(given.opacities, "opacities", {count}, reals, Access::reads);
  check(given.scales, "scales", {count, 3}, reals, Access::reads);
  check(given.counts, "counts", {count}, kIntegers, Access::reads);
  check(given.new_opacities, "new_opacities", {count}, 1u << given.opacities.type, Access::writes);
  check(given.new_scales, "new_scales", {count, 3}, 1u << given.scales.type, Access::writes);
  return count;
}

int copies_at(const QsArray& counts, std::int64_t i) {
  return with_type(counts, [&](const auto* elements) {
    const auto value = elements[i * counts.strides[0]];
    using Value = std::remove_const_t<decltype(value)>;
    return static_cast<int>(std::clamp(value, Value(1), Value(kMostCopies)));
  });
}

void relocate_on_host(const RelocationArrays& given, std::int64_t i) {
  const Relocation shared = with_type(given.opacities, [&](const auto* from) {
    return shared_place(static_cast<double>(from[i * given.opacities.strides[0]]),
                        copies_at(given.counts, i));
  });
  with_type(given.new_opacities, [&](auto* to) {
    to[i * given.new_opacities.strides[0]] =
        static_cast<std::remove_pointer_t<decltype(to)>>(shared.opacity);
  });
  with_type(given.new_scales, [&](auto* to) {
    using Real = std::remove_pointer_t<decltype(to)>;
    const auto* const from = static_cast<const Real*>(given.scales.data);
    for (int axis = 0; axis < 3; ++axis) {
      const Real scale = from[offset_of(given.scales, i, axis)];
      to[offset_of(given.new_scales, i, axis)] =
          static_cast<Real>(static_cast<double>(scale) * shared.scale_factor);
    }
  });
}

/// Runs a part for `count` Gaussians on the GPU of the context, whose array `where` has this place.
template <class Part>
void run_on_gpu([[maybe_unused]] const Part& part, [[maybe_unused]] std::int64_t count,
                const Place& place, const Where& where, const Use& use,
                [[maybe_unused]] void* stream) {
  use.require_gpu(place.device, where);
#ifdef QUADSPLAT_HAVE_CUDA
  const cuda::diff::SelectedGpu selected(use.device());
  cuda::diff::enqueue(part, static_cast<std::size_t>(count), {stream, use.stop()});
#endif
}

/// Runs a part where its arrays are.
template <class Part>
void run(const Part& part, std::int64_t count, const Place& place, const Where& where,
         const Use& use, void* stream) {
  if (place.is_gpu())
    run_on_gpu(part, count, place, where, use, stream);
  else
    use.pool().for_each(static_cast<std::size_t>(count), 256, part);
}

void relocate_on_gpu(const RelocationArrays& given, std::int64_t count, const Use& use) {
  with_type(given.counts, [&](const auto* counts) {
    using Count = std::remove_cvref_t<decltype(*counts)>;
    if constexpr (std::is_integral_v<Count> && sizeof(Count) >= 4)
      run_on_gpu(diff::Relocations<Count>{rows_of<const float>(given.opacities),
                                          rows_of<const float>(given.scales),
                                          rows_of<const Count>(given.counts),
                                          rows_of<float>(given.new_opacities),
                                          rows_of<float>(given.new_scales)},
                 count, given.place(), {"qs_relocate", "opacities"}, use, use.stream());
  });
}

}  // namespace

int32_t qs_relocate(QsContext* context, const QsArray* opacities, const QsArray* scales,
                    const QsArray* counts, const QsArray* new_opacities, const QsArray* new_scales,
                    char* message) {
  return library::call(__func__, message, [&](const char* function) {
    require_all(function, {{"context", context},
                           {"opacities", opacities},
                           {"scales", scales},
                           {"counts", counts},
                           {"new_opacities", new_opacities},
                           {"new_scales", new_scales}});
    const RelocationArrays given{*opacities, *scales, *counts, *new_opacities, *new_scales};
    const std::int64_t count = check_relocation(given);
    const Use use(*context->context, {function, "context"});
    if (given.place().is_gpu()) {
      relocate_on_gpu(given, count, use);
      return;
    }
    use.pool().for_each(static_cast<std::size_t>(count), 64, [&](std::size_t i) {
      relocate_on_host(given, static_cast<std::int64_t>(i));
    });
  });
}

int32_t qs_covariances(QsContext* context, const QsArray* rotations, const QsArray* scales,
                       const QsArray* covariances, char* message) {
  return library::call(__func__, message, [&](const char* function) {
    require_all(function, {{"context", context},
                           {"rotations", rotations},
                           {"scales", scales},
                           {"covariances", covariances}});
    const Where of_rotations{function, "rotations"};
    check_dimensions(*rotations, of_rotations, 2);
    const std::int64_t count = rotations->sizes[0];
    const Place place{rotations->memory, rotations->device, "rotations"};
    check_array(*rotations, of_rotations, {count, 4}, kFloat32, Access::reads, place);
    check_array(*scales, {function, "scales"}, {count, 3}, kFloat32, Access::reads, place);
    const bool is_packed = covariances->dimensions == 2;
    const std::array<std::int64_t, 3> sizes{count, is_packed ? 6 : 3, 3};
    check_array(*covariances, {function, "covariances"}, std::span(sizes).first(is_packed ? 2 : 3),
                kFloat32, Access::writes, place);
    const Use use(*context->context, {function, "context"});
    const std::int64_t* const strides = covariances->strides;
    run(diff::Covariances{rows_of<const float>(*rotations), rows_of<const float>(*scales),
                          static_cast<float*>(covariances->data), strides[0],
                          is_packed ? 0 : strides[1], is_packed ? strides[1] : strides[2]},
        count, place, of_rotations, use, use.stream());
  });
}

int32_t qs_add_view(QsContext* context, const QsArray* gradients, const QsArray* radii, double x,
                    double y, const QsArray* lengths, const QsArray* views, char* message) {
  return library::call(__func__, message, [&](const char* function) {
    require_all(function, {{"context", context},
                           {"gradients", gradients},
                           {"radii", radii},
                           {"lengths", lengths},
                           {"views", views}});
    const Where of_gradients{function, "gradients"};
    check_dimensions(*gradients, of_gradients, 2);
    const std::int64_t count = gradients->sizes[0];
    const Place place{gradients->memory, gradients->device, "gradients"};
    check_array(*gradients, of_gradients, {count, 2}, kFloat32, Access::reads, place);
    check_array(*radii, {function, "radii"}, {count, 2}, 1u << QS_INT32, Access::reads, place);
    check_array(*lengths, {function, "lengths"}, {count}, kFloat32, Access::writes, place);
    check_array(*views, {function, "views"}, {count}, kFloat32, Access::writes, place);
    const Use use(*context->context, {function, "context"});
    run(diff::ViewSums{rows_of<const float>(*gradients), rows_of<const std::int32_t>(*radii),
                       static_cast<float>(x), static_cast<float>(y), rows_of<float>(*lengths),
                       rows_of<float>(*views)},
        count, place, of_gradients, use, use.stream());
  });
}

int32_t qs_noise(QsContext* context, const QsNoise* noise, char* message) {
  return library::call(__func__, message, "context", context, [&](const char* function) {
    const Where where{function, "noise"};
    const QsNoise given = read_struct(noise, where);
    if (given.reserved != 0) refuse(where / "reserved", "is not 0");
    for (const auto& [value, name] :
         {std::pair{given.factor, "factor"}, {given.slope, "slope"}, {given.middle, "middle"}})
      if (!std::isfinite(value)) refuse(where / name, "is {}", value);
    check_dimensions(given.means, where / "means", 2);
    const std::int64_t count = given.means.sizes[0];
    const Place place{given.means.memory, given.means.device, "means"};
    ArrayChecks{where, kFloat32, Access::writes, place}.given(given.means, "means", {count, 3});
    const ArrayChecks read{where, kFloat32, Access::reads, place};
    read.given(given.log_scales, "log_scales", {count, 3});
    read.given(given.rotations, "rotations", {count, 4});
    read.given(given.opacity_logits, "opacity_logits", {count});
    read.given(given.normals, "normals", {count, 3});
    const Use use(*context->context, {function, "context"});
    run(diff::NoisyMeans{rows_of<float>(given.means),
                         rows_of<const float>(given.log_scales),
                         rows_of<const float>(given.rotations),
                         rows_of<const float>(given.opacity_logits),
                         rows_of<const float>(given.normals),
                         {given.factor, given.slope, given.middle}},
        count, place, where / "means", use, given.stream);
  });
}
