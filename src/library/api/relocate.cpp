// SPDX-License-Identifier: MIT
//
// Opacities and scales of the copies that replace a Gaussian.
#include <algorithm>
#include <cstdint>

#include "learn/step/relocation.h"
#include "library/check/arrays.h"
#include "library/check/context.h"

using namespace qs::library;

namespace {

static_assert(QS_MOST_COPIES == train::kMostCopies);

struct RelocationArrays {
  const QsArray &opacities, &scales, &counts, &new_opacities, &new_scales;
};

std::int64_t check_relocation(const RelocationArrays& given) {
  constexpr const char* kCall = "qs_relocate";
  check_dimensions(given.opacities, {kCall, "opacities"}, 1);
  const std::int64_t count = given.opacities.sizes[0];
  if (count > kMostGaussians) refuse({kCall, "opacities"}, "{} Gaussians are too many", count);
  const auto check = [&](const QsArray& array, const char* name,
                         std::initializer_list<std::int64_t> sizes, Types types, Access access) {
    check_array(array, {kCall, name}, sizes, types, access);
  };
  check(given.opacities, "opacities", {count}, kReals, Access::reads);
  check(given.scales, "scales", {count, 3}, kReals, Access::reads);
  check(given.counts, "counts", {count}, kIntegers, Access::reads);
  check(given.new_opacities, "new_opacities", {count}, 1u << given.opacities.type, Access::writes);
  check(given.new_scales, "new_scales", {count, 3}, 1u << given.scales.type, Access::writes);
  return count;
}

int copies_at(const QsArray& counts, std::int64_t i) {
  return with_type(counts, [&](const auto* elements) {
    const auto value = elements[i * counts.strides[0]];
    using Value = std::remove_const_t<decltype(value)>;
    return static_cast<int>(std::clamp(value, Value(1), Value(train::kMostCopies)));
  });
}

void relocate(const RelocationArrays& given, std::int64_t i) {
  const int copies = copies_at(given.counts, i);
  const train::Relocation shared =
      with_type(given.opacities, [&](const auto* from) -> train::Relocation {
        const auto opacity = static_cast<double>(from[i * given.opacities.strides[0]]);
        const bool stays = copies == 1 || !(opacity >= 0 && opacity <= 1);
        return stays ? train::Relocation{opacity, 1} : train::relocated(opacity, copies);
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
    use.pool().for_each(static_cast<std::size_t>(count), 64,
                        [&](std::size_t i) { relocate(given, static_cast<std::int64_t>(i)); });
  });
}
