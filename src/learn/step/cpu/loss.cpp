// SPDX-License-Identifier: MIT
#include "learn/step/cpu/loss.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numeric>
#include <utility>

namespace qs::cpu::train {
namespace {

constexpr std::size_t kChannels = 3;

// The values of picture and photograph, channel by channel.
template <class Real>
struct ComparedValues {
  const Real* picture;
  const float* photograph;
  std::span<const std::uint8_t> mask;

  bool is_masked(std::size_t i) const { return !mask.empty() && mask[i / kChannels] == 0; }
};

// The sum of SSIM over the values that are not masked. Masked values count as outside of both
// pictures. `fields` become the arguments of LossGradient.
template <class Real>
double sum_ssim(const PictureRows& shape, const ComparedValues<Real>& values,
                SsimFields<Real>& fields) {
  fields.resize(shape.all_values());
  shape.for_rows([&](std::size_t y) {
    for (std::size_t i = y * shape.values(); i < (y + 1) * shape.values(); ++i) {
      const bool out = values.is_masked(i);
      fields.a[i] = out ? 0 : shown(values.picture[i]);
      fields.b[i] = out ? 0 : values.photograph[i];
    }
  });
  fields.find_moments(shape);
  const double sum = fields.sum_similarity(shape, {values.mask});
  fields.spread_derivatives(shape);
  return sum;
}

// Sums of the absolute and of the squared differences. Sets `d`, the gradient of the loss.
template <class Real>
std::pair<double, double> sum_differences(const PictureRows& shape,
                                          const ComparedValues<Real>& values,
                                          const LossGradient<Real>& gradient,
                                          const SsimFields<Real>& by, Real* d) {
  std::vector<double> squares(shape.height);
  const double absolute = shape.sum_of_rows([&](std::size_t y) {
    double sum = 0;
    for (std::size_t i = y * shape.values(); i < (y + 1) * shape.values(); ++i) {
      if (values.is_masked(i)) {
        d[i] = 0;
        continue;
      }
      const Real a = values.picture[i], b = values.photograph[i];
      const double difference = static_cast<double>(shown(a)) - static_cast<double>(b);
      sum += std::abs(static_cast<double>(shown(a) - b));
      squares[y] += difference * difference;
      d[i] = gradient.by(a, b, by.a[i], by.aa[i], by.ab[i]);
    }
    return sum;
  });
  return {absolute, std::accumulate(squares.begin(), squares.end(), 0.0)};
}

}  // namespace

template <class Real>
Loss compare(const LossInput<Real>& in, ThreadPool& pool, SsimFields<Real>& fields,
             std::vector<glm::vec<3, Real>>& d_color) {
  const PictureRows shape{static_cast<std::size_t>(in.width), static_cast<std::size_t>(in.height),
                          kChannels, pool};
  const std::size_t count = shape.all_values();
  assert(in.color.size() * kChannels == count && in.target.size() == in.color.size());
  assert(in.mask.empty() || in.mask.size() == in.color.size());
  const auto masked = std::count(in.mask.begin(), in.mask.end(), std::uint8_t{0});
  const auto total = static_cast<double>(count - static_cast<std::size_t>(masked) * kChannels);
  const ComparedValues<Real> values{&in.color[0][0], &in.target[0][0], in.mask};
  d_color.resize(in.color.size());

  const double ssim = sum_ssim(shape, values, fields);
  const auto [l1, squares] =
      sum_differences(shape, values, LossGradient<Real>::of(total), fields, &d_color[0][0]);
  return Loss::of_sums(l1, ssim, squares, total);
}

template decltype(compare<float>) compare<float>;
template decltype(compare<double>) compare<double>;

}  // namespace qs::cpu::train
