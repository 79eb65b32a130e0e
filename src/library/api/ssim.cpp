// SPDX-License-Identifier: MIT
//
// SSIM of pictures in batches, and its derivatives.

#include "raster/kernel/ssim.h"

#include <algorithm>
#include <cstdint>

#include "learn/step/cpu/loss.h"
#include "library/check/arrays.h"
#include "library/check/context.h"

using namespace qs::library;

namespace {

using cpu::train::CountedPixels;
using cpu::train::PictureRows;
using cpu::train::SsimFields;

constexpr std::int64_t kMostPixelsOfAChannel = std::int64_t{1} << 29;

/// The arguments that both functions share.
struct SsimCall {
  const char* name;  ///< the function
  const QsArray &a, &b;
  std::uint32_t border;

  std::int64_t size(int dimension) const { return a.sizes[dimension]; }
  std::int64_t margin() const { return border == QS_BORDER_CROP ? kSsimRadius : 0; }

  /// Throws Error(usage).
  void check() const {
    const Where of_a{name, "a"};
    check_dimensions(a, of_a, 4);
    for (int i = 0; i < 4; ++i)
      if (size(i) < 1) refuse(of_a, "its size of dimension {} is {}", i, size(i));
    if (std::max(size(2), size(3)) > kMostPixelsOfAChannel ||
        size(2) * size(3) > kMostPixelsOfAChannel)
      refuse(of_a, "{} x {} pixels are too many", size(3), size(2));
    check_like_a(a, of_a, kReals, Access::reads);
    check_like_a(b, {name, "b"}, 1u << a.type, Access::reads);
    if (border > QS_BORDER_CROP) refuse({name, "border"}, "is {}", border);
    if (margin() > 0 && std::min(size(2), size(3)) < kSsimSize)
      refuse({name, "border"}, "QS_BORDER_CROP needs {} pixels along each side, not {} x {}",
             kSsimSize, size(3), size(2));
  }
  void check_like_a(const QsArray& array, const Where& where, Types types, Access access) const {
    check_array(array, where, {size(0), size(1), size(2), size(3)}, types, access);
  }

  /// The number of values in the mean.
  double counted() const {
    return static_cast<double>(size(0)) * static_cast<double>(size(1)) *
           static_cast<double>((size(2) - 2 * margin()) * (size(3) - 2 * margin()));
  }
};

/// A channel of a picture of the batch, element by element.
template <class Real>
struct Plane {
  Real* first;
  std::ptrdiff_t down, right;

  Plane(const QsArray& array, std::int64_t picture, std::int64_t channel)
      : first(static_cast<Real*>(array.data) + picture * array.strides[0] +
              channel * array.strides[1]),
        down(array.strides[2]),
        right(array.strides[3]) {}

  Real& at(std::size_t x, std::size_t y) const {
    return first[static_cast<std::ptrdiff_t>(y) * down + static_cast<std::ptrdiff_t>(x) * right];
  }
};

/// The sum of SSIM over the batch. Calls with_derivatives(a, b, picture, channel, fields) for each
/// channel, with the planes of a and b.
template <class Real, class WithDerivatives>
double for_planes(const SsimCall& call, ThreadPool& pool, const WithDerivatives& with_derivatives) {
  const PictureRows rows{static_cast<std::size_t>(call.size(3)),
                         static_cast<std::size_t>(call.size(2)), 1, pool};
  const CountedPixels counted{{}, static_cast<std::size_t>(call.margin())};
  SsimFields<Real> fields;
  fields.resize(rows.all_values());
  double sum = 0;
  for (std::int64_t picture = 0; picture < call.size(0); ++picture) {
    for (std::int64_t channel = 0; channel < call.size(1); ++channel) {
      const Plane<const Real> a(call.a, picture, channel), b(call.b, picture, channel);
      rows.for_rows([&](std::size_t y) {
        for (std::size_t x = 0; x < rows.width; ++x) {
          fields.a[y * rows.width + x] = a.at(x, y);
          fields.b[y * rows.width + x] = b.at(x, y);
        }
      });
      fields.find_moments(rows);
      sum += fields.sum_similarity(rows, counted);
      with_derivatives(rows, a, b, picture, channel, fields);
    }
  }
  return sum;
}

template <class Real>
void write_gradient(const SsimCall& call, double by_mean, const QsArray& by_a, ThreadPool& pool) {
  const auto weight = static_cast<Real>(by_mean / call.counted());
  for_planes<Real>(
      call, pool,
      [&](const PictureRows& rows, const Plane<const Real>& a, const Plane<const Real>& b,
          std::int64_t picture, std::int64_t channel, SsimFields<Real>& fields) {
        fields.spread_derivatives(rows);
        const Plane<Real> by(by_a, picture, channel);
        rows.for_rows([&](std::size_t y) {
          for (std::size_t x = 0; x < rows.width; ++x) {
            const std::size_t i = y * rows.width + x;
            by.at(x, y) = weight * similarity_by(a.at(x, y), b.at(x, y), fields.a[i], fields.aa[i],
                                                 fields.ab[i]);
          }
        });
      });
}

}  // namespace

int32_t qs_ssim(QsContext* context, const QsArray* a, const QsArray* b, uint32_t border,
                double* mean, char* message) {
  return library::call(__func__, message, [&](const char* function) {
    require_all(function, {{"context", context}, {"a", a}, {"b", b}, {"mean", mean}});
    const SsimCall call{function, *a, *b, border};
    call.check();
    const Use use(*context->context, {function, "context"});
    const auto nothing = [](const auto&...) {};
    const double sum = a->type == QS_FLOAT64 ? for_planes<double>(call, use.pool(), nothing)
                                             : for_planes<float>(call, use.pool(), nothing);
    *mean = sum / call.counted();
  });
}

int32_t qs_ssim_backward(QsContext* context, const QsArray* a, const QsArray* b, uint32_t border,
                         double by_mean, const QsArray* by_a, char* message) {
  return library::call(__func__, message, [&](const char* function) {
    require_all(function, {{"context", context}, {"a", a}, {"b", b}, {"by_a", by_a}});
    const SsimCall call{function, *a, *b, border};
    call.check();
    call.check_like_a(*by_a, {function, "by_a"}, 1u << a->type, Access::writes);
    const Use use(*context->context, {function, "context"});
    if (a->type == QS_FLOAT64)
      write_gradient<double>(call, by_mean, *by_a, use.pool());
    else
      write_gradient<float>(call, by_mean, *by_a, use.pool());
  });
}
