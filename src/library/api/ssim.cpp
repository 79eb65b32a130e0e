// SPDX-License-Identifier: MIT
//
// SSIM and absolute differences of pictures in batches, and their derivatives.

#include "raster/kernel/ssim.h"

#include <algorithm>
#include <cstdint>

#include "learn/step/cpu/loss.h"
#include "library/check/arrays.h"
#include "library/check/context.h"
#include "library/check/stage_arguments.h"
#include "library/check/structs.h"
#ifdef QUADSPLAT_HAVE_CUDA
#include "learn/diff/cuda/ssim.h"
#include "library/check/gpu_memory.h"
#endif

using namespace qs::library;

namespace {

using cpu::train::CountedPixels;
using cpu::train::PictureRows;
using cpu::train::SsimFields;

constexpr std::int64_t kMostPixelsOfAChannel = std::int64_t{1} << 29;

/// The arguments that all functions share.
struct SsimCall {
  const char* name;  ///< the function
  const QsArray &a, &b;
  std::uint32_t border;
  Place place = {};

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
    check_array(array, where, {size(0), size(1), size(2), size(3)}, types, access, place);
  }

  /// The number of values in the mean.
  double counted() const { return values(margin()); }
  /// The number of values `left_out` pixels or more from every side.
  double values(std::int64_t left_out = 0) const {
    return static_cast<double>(size(0)) * static_cast<double>(size(1)) *
           static_cast<double>((size(2) - 2 * left_out) * (size(3) - 2 * left_out));
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

/// The sum of each(a, b) over all values of a channel, with the planes of a and b.
template <class Real, class Each>
double sum_of_values(const PictureRows& rows, const Plane<const Real>& a,
                     const Plane<const Real>& b, const Each& each) {
  return rows.sum_of_rows([&](std::size_t y) {
    double sum = 0;
    for (std::size_t x = 0; x < rows.width; ++x) sum += each(a.at(x, y), b.at(x, y));
    return sum;
  });
}

/// The means of SSIM, and of absolute differences.
struct Means {
  double ssim, l1;
};

template <class Real>
Means means_of(const SsimCall& call, ThreadPool& pool, bool with_l1) {
  double l1 = 0;
  const double ssim = for_planes<Real>(
      call, pool,
      [&](const PictureRows& rows, const Plane<const Real>& a, const Plane<const Real>& b,
          std::int64_t, std::int64_t, const SsimFields<Real>&) {
        if (with_l1)
          l1 += sum_of_values(rows, a, b,
                              [](Real x, Real y) { return std::abs(static_cast<double>(x - y)); });
      });
  return {ssim / call.counted(), l1 / call.values()};
}

/// Writes the derivatives from those by the means.
template <class Real>
void write_gradient(const SsimCall& call, const Means& by, const QsArray& by_a, ThreadPool& pool) {
  const auto weight = static_cast<Real>(by.ssim / call.counted());
  const auto l1_weight = static_cast<Real>(by.l1 / call.values());
  for_planes<Real>(
      call, pool,
      [&](const PictureRows& rows, const Plane<const Real>& a, const Plane<const Real>& b,
          std::int64_t picture, std::int64_t channel, SsimFields<Real>& fields) {
        fields.spread_derivatives(rows);
        const Plane<Real> to(by_a, picture, channel);
        rows.for_rows([&](std::size_t y) {
          for (std::size_t x = 0; x < rows.width; ++x) {
            const std::size_t i = y * rows.width + x;
            const Real own = a.at(x, y), other = b.at(x, y);
            Real gradient =
                weight * similarity_by(own, other, fields.a[i], fields.aa[i], fields.ab[i]);
            if (l1_weight != 0)
              gradient += l1_weight * static_cast<Real>((own > other) - (own < other));
            to.at(x, y) = gradient;
          }
        });
      });
}

Means means_on_host(const SsimCall& call, ThreadPool& pool, bool with_l1) {
  return call.a.type == QS_FLOAT64 ? means_of<double>(call, pool, with_l1)
                                   : means_of<float>(call, pool, with_l1);
}

void write_gradient_on_host(const SsimCall& call, const Means& by, const QsArray& by_a,
                            ThreadPool& pool) {
  if (call.a.type == QS_FLOAT64)
    write_gradient<double>(call, by, by_a, pool);
  else
    write_gradient<float>(call, by, by_a, pool);
}

/// The arguments of qs_similarity() and qs_similarity_backward(), checked but for their arrays.
struct SimilarityCall {
  const char* name;
  QsSimilarity given;
  SsimCall pictures;

  SimilarityCall(const char* function, const QsSimilarity* compared)
      : name(function),
        given(read_struct(compared, {function, "compared"})),
        pictures{function, given.a, given.b, given.border,
                 Place{given.a.memory, given.a.device, "a"}} {
    pictures.check();
    if (is_on_gpu() && given.a.type != QS_FLOAT32)
      refuse(where("a"), "has elements of float64: a GPU takes QS_FLOAT32");
  }

  bool is_on_gpu() const { return pictures.place.is_gpu(); }
  Where where(const char* member) const { return Where{name, "compared"} / member; }

  void check_number(const QsArray& array, const char* member, Access access) const {
    check_array(array, where(member), {1}, is_on_gpu() ? kFloat32 : kReals, access, pictures.place);
  }
  void check_terms(Access access) const {
    check_array(given.terms, where("terms"),
                {3, pictures.size(0), pictures.size(1), pictures.size(2) * pictures.size(3)},
                kFloat32, access, pictures.place);
    if (given.terms.strides[3] != 1 || given.terms.strides[2] != given.terms.sizes[3] ||
        given.terms.strides[1] != given.terms.sizes[2] * given.terms.strides[2] ||
        given.terms.strides[0] != given.terms.sizes[1] * given.terms.strides[1])
      refuse(where("terms"), "is not packed");
  }
};

double number_in(const QsArray& array) {
  return is_absent(array) ? 0 : numbers_in<double>(array)[0];
}

#ifdef QUADSPLAT_HAVE_CUDA

namespace gpu = cuda::diff;

/// A checked call on the GPU of the context.
class GpuSimilarity {
 public:
  GpuSimilarity(const SimilarityCall& call, const Use& use)
      : given_(call.given),
        selected_(use.device()),
        queue_{given_.stream, use.stop()},
        temporary_(call.where("temporary"), given_.temporary, queue_) {
    const SsimCall& pictures = call.pictures;
    const auto size = [&](int dimension) { return static_cast<int>(pictures.size(dimension)); };
    if (pictures.values() > INT32_MAX) refuse(call.where("a"), "has too many values for a GPU");
    compared_ = {{size(0), size(1), size(2), size(3), static_cast<int>(pictures.margin())},
                 batch_of<const float>(given_.a),
                 batch_of<const float>(given_.b)};
  }

  void forward() {
    void* const scratch = temporary_.allocate(gpu::bytes_for_similarity(compared_.sizes));
    gpu::similarity(compared_, queue_, scratch, numbers(given_.ssim), numbers(given_.l1),
                    numbers(given_.terms));
  }
  void backward() {
    gpu::similarity_backward(compared_, numbers(given_.terms), numbers(given_.by_ssim),
                             numbers(given_.by_l1), queue_, batch_of<float>(given_.by_a));
  }

 private:
  /// Null if it is absent.
  static float* numbers(const QsArray& array) {
    return is_absent(array) ? nullptr : static_cast<float*>(array.data);
  }
  template <class T>
  static gpu::PictureBatch<T> batch_of(const QsArray& array) {
    return {{static_cast<T*>(array.data), array.strides[2], array.strides[3], array.strides[1]},
            array.strides[0]};
  }

  const QsSimilarity& given_;
  gpu::SelectedGpu selected_;
  gpu::Queue queue_;
  Temporary temporary_;
  gpu::ComparedPictures compared_{};
};

#else

/// No context has a GPU.
struct GpuSimilarity {
  GpuSimilarity(const SimilarityCall&, const Use&) {}
  void forward() {}
  void backward() {}
};

#endif

}  // namespace

int32_t qs_ssim(QsContext* context, const QsArray* a, const QsArray* b, uint32_t border,
                double* mean, char* message) {
  return library::call(__func__, message, [&](const char* function) {
    require_all(function, {{"context", context}, {"a", a}, {"b", b}, {"mean", mean}});
    const SsimCall call{function, *a, *b, border};
    call.check();
    const Use use(*context->context, {function, "context"});
    *mean = means_on_host(call, use.pool(), false).ssim;
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
    write_gradient_on_host(call, {by_mean, 0}, *by_a, use.pool());
  });
}

int32_t qs_similarity(QsContext* context, const QsSimilarity* compared, char* message) {
  return library::call(__func__, message, "context", context, [&](const char* function) {
    const SimilarityCall call(function, compared);
    const QsSimilarity& given = call.given;
    call.check_number(given.ssim, "ssim", Access::writes);
    if (!is_absent(given.l1)) call.check_number(given.l1, "l1", Access::writes);
    if (!is_absent(given.terms)) call.check_terms(Access::writes);
    const Use use(*context->context, {function, "context"});
    if (call.is_on_gpu()) {
      use.require_gpu(given.a.device, call.where("a"));
      GpuSimilarity(call, use).forward();
      return;
    }
    const Means means = means_on_host(call.pictures, use.pool(), !is_absent(given.l1));
    store_numbers(given.ssim, [&](auto, auto) { return means.ssim; });
    store_numbers(given.l1, [&](auto, auto) { return means.l1; });
  });
}

int32_t qs_similarity_backward(QsContext* context, const QsSimilarity* compared, char* message) {
  return library::call(__func__, message, "context", context, [&](const char* function) {
    const SimilarityCall call(function, compared);
    const QsSimilarity& given = call.given;
    call.check_number(given.by_ssim, "by_ssim", Access::reads);
    if (!is_absent(given.by_l1)) call.check_number(given.by_l1, "by_l1", Access::reads);
    call.pictures.check_like_a(given.by_a, call.where("by_a"), 1u << given.a.type, Access::writes);
    if (call.is_on_gpu()) call.check_terms(Access::reads);
    const Use use(*context->context, {function, "context"});
    if (call.is_on_gpu()) {
      use.require_gpu(given.a.device, call.where("a"));
      GpuSimilarity(call, use).backward();
      return;
    }
    const Means by{number_in(given.by_ssim), number_in(given.by_l1)};
    write_gradient_on_host(call.pictures, by, given.by_a, use.pool());
  });
}
