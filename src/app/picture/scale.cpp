// SPDX-License-Identifier: MIT
#include "app/picture/scale.h"

#include <algorithm>

namespace qs {

std::vector<std::uint32_t> Scale::ticks() const {
  std::vector<std::uint32_t> result;
  // A step that ends just below the maximum would collide with it.
  for (std::uint64_t tick = 0; tick == 0 || 2 * tick + step <= 2 * std::uint64_t{maximum};
       tick += step)
    result.push_back(static_cast<std::uint32_t>(tick));
  result.push_back(maximum);
  return result;
}

Scale round_scale(std::uint32_t maximum) {
  constexpr std::uint64_t kMostSteps = 8;
  constexpr std::uint64_t kLargest = 4'000'000'000;
  const std::uint64_t reach = std::clamp<std::uint64_t>(maximum, 1, kLargest);
  const auto steps_of = [reach](std::uint64_t step) { return (reach + step - 1) / step; };
  const auto step = static_cast<std::uint64_t>(round_step(
      1, [&](double size) { return steps_of(static_cast<std::uint64_t>(size)) <= kMostSteps; }));
  return {static_cast<std::uint32_t>(step), static_cast<std::uint32_t>(steps_of(step) * step)};
}

Scale exact_scale(std::uint32_t maximum) {
  const std::uint32_t end = std::max(maximum, 1u);
  return {round_scale(end).step, end};
}

Scale scale_for(std::span<const std::uint32_t> values) {
  if (values.empty()) return {};
  std::vector<std::uint32_t> sorted(values.begin(), values.end());
  const auto nth = sorted.begin() + static_cast<std::ptrdiff_t>((sorted.size() - 1) * 995 / 1000);
  std::nth_element(sorted.begin(), nth, sorted.end());
  return round_scale(*nth);
}

Scale scale_for_signed(std::span<const std::int32_t> values) {
  std::vector<std::uint32_t> sizes;
  sizes.reserve(values.size());
  for (const std::int32_t value : values)
    sizes.push_back(static_cast<std::uint32_t>(value < 0 ? -std::int64_t{value} : value));
  return scale_for(sizes);
}

}  // namespace qs
