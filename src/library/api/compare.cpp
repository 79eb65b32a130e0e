// SPDX-License-Identifier: MIT
//
// The metrics of two pictures.
#include <algorithm>
#include <cstdint>
#include <vector>

#include "learn/lpips/metric.h"
#include "library/check/arrays.h"
#include "library/check/context.h"
#include "library/check/gpu_arrays.h"
#include "library/check/structs.h"
#include "raster/scene/image_metrics.h"
#ifdef QUADSPLAT_HAVE_CUDA
#include "learn/diff/cuda/compare.h"
#include "library/check/gpu_memory.h"
#endif

using namespace qs::library;

namespace {

constexpr Types kPictures = kReals | kBytes;
constexpr std::int64_t kMostValues = std::int64_t{1} << 29;  // the limit for files of pictures, too
constexpr std::uint32_t kAllMetrics = QS_METRIC_PSNR | QS_METRIC_PSNR_8BIT | QS_METRIC_SSIM |
                                      QS_METRIC_FLIP | QS_METRIC_LPIPS | QS_METRIC_LPIPS_PAPER;
constexpr std::uint32_t kLpips = QS_METRIC_LPIPS | QS_METRIC_LPIPS_PAPER;

/// `place`: of both pictures and the mask.
void check_pictures(const QsArray& a, const QsArray& b, const QsComparison& comparison,
                    const Place& place) {
  const Where of_a{"qs_compare", "a"}, of_b{"qs_compare", "b"};
  const Where where{"qs_compare", "comparison"};
  check_dimensions(a, of_a, 3);
  const std::int64_t height = a.sizes[0], width = a.sizes[1];
  if (height < 1 || width < 1) refuse(of_a, "has no pixel: it is {} x {}", width, height);
  if (std::max(height, width) > kMostValues || height * width * 3 > kMostValues)
    refuse(of_a, "{} x {} pixels are too many", width, height);
  check_array(a, of_a, {height, width, 3}, kPictures, Access::reads, place);
  check_array(b, of_b, {height, width, 3}, kPictures, Access::reads, place);
  if (comparison.reserved != 0) refuse(where / "reserved", "is not 0");
  if (comparison.metrics == 0 || (comparison.metrics & ~kAllMetrics) != 0)
    refuse(where / "metrics", "{} is no sum of QS_METRIC_...", comparison.metrics);
  if (comparison.ssim_border > QS_BORDER_CROP)
    refuse(where / "ssim_border", "is {}", comparison.ssim_border);
  if ((comparison.metrics & QS_METRIC_SSIM) != 0 && comparison.ssim_border == QS_BORDER_CROP &&
      std::min(width, height) < kSsimSize)
    refuse(where / "ssim_border", "QS_BORDER_CROP needs {} pixels along each side, not {} x {}",
           kSsimSize, width, height);
  if ((comparison.metrics & kLpips) != 0)
    require_text(comparison.lpips_weights, where / "lpips_weights");
  if (is_absent(comparison.mask)) return;
  check_array(comparison.mask, where / "mask", {height, width}, kBytes, Access::reads, place);
  if ((comparison.metrics & ~(QS_METRIC_PSNR | QS_METRIC_SSIM)) != 0)
    refuse(where / "mask", "belongs to QS_METRIC_PSNR and QS_METRIC_SSIM alone");
}

Image unit_image_of(const QsArray& array, ThreadPool& pool) {
  Image image = image_of(array, pool);
  clamp_to_unit(image);
  return image;
}

bool wants(const QsComparison& comparison, std::uint32_t metrics) {
  return (comparison.metrics & metrics) != 0;
}

void compare_on_host(const QsArray& mask, const Image& a, const Image& b, ThreadPool& pool,
                     QsComparison& result) {
  std::vector<std::uint8_t> counted;
  if (!is_absent(mask)) {
    counted.resize(a.values.size() / 3);
    gather(mask, pool, counted.data(), [](auto value) { return static_cast<std::uint8_t>(value); });
  }
  const SsimBorder border =
      result.ssim_border == QS_BORDER_ZEROS ? SsimBorder::zeros : SsimBorder::crop;
  if (wants(result, QS_METRIC_PSNR)) result.psnr = psnr(a, b, pool, counted);
  if (wants(result, QS_METRIC_PSNR_8BIT)) result.psnr_8bit = psnr_8bit(a, b);
  if (wants(result, QS_METRIC_SSIM)) result.ssim = ssim(a, b, pool, border, counted);
}

#ifdef QUADSPLAT_HAVE_CUDA

cuda::diff::GivenPicture given_picture(const QsArray& array) {
  if (is_absent(array)) return {};
  const int bytes = array.type == QS_FLOAT64 ? 8 : array.type == QS_FLOAT32 ? 4 : 1;
  return {array.data, array.strides[0], array.strides[1], array.strides[2], bytes};
}

void compare_on_gpu(const QsArray& a, const QsArray& b, const Use& use, QsComparison& result) {
  const cuda::diff::SelectedGpu selected(use.device());
  const cuda::diff::Queue queue{use.stream(), use.stop()};
  const cuda::diff::GivenPictures pictures{given_picture(a),
                                           given_picture(b),
                                           given_picture(result.mask),
                                           static_cast<int>(a.sizes[1]),
                                           static_cast<int>(a.sizes[0]),
                                           result.ssim_border == QS_BORDER_CROP ? kSsimRadius : 0};
  Temporary temporary({"qs_compare", "context"}, nullptr, queue);
  const auto sums = cuda::diff::compare(pictures, wants(result, QS_METRIC_SSIM), queue,
                                        temporary.allocate(bytes_to_compare(pictures)));
  if (wants(result, QS_METRIC_PSNR)) result.psnr = sums.psnr();
  if (wants(result, QS_METRIC_PSNR_8BIT)) result.psnr_8bit = sums.psnr_8bit();
  if (wants(result, QS_METRIC_SSIM)) result.ssim = sums.mean_ssim();
}

#else

/// No context has a GPU.
void compare_on_gpu(const QsArray&, const QsArray&, const Use&, QsComparison&) {}

#endif

/// Sets the distances that are asked for.
void compare_features(Context& context, const Image& a, const Image& b, QsComparison& comparison) {
  if (!wants(comparison, kLpips)) return;
  const lpips::Weights weights = read_lpips(comparison.lpips_weights);
  const int side = lpips::smallest_side(*weights.network);
  if (std::min(a.width, a.height) < side)
    refuse({"qs_compare", "a"}, "has {} x {} pixels, and LPIPS with {} needs {} x {} at least",
           a.width, a.height, weights.network->name, side, side);
  const LpipsDistance distance =
      make_lpips(context.backend(), weights, context.pool(), context.device());
  if (wants(comparison, QS_METRIC_LPIPS))
    comparison.lpips = distance(a, b, lpips::InputRange::symmetric);
  if (wants(comparison, QS_METRIC_LPIPS_PAPER))
    comparison.lpips_paper = distance(a, b, lpips::InputRange::unit);
}

}  // namespace

int32_t qs_compare(QsContext* context, const QsArray* a, const QsArray* b, QsComparison* comparison,
                   char* message) {
  return library::call(__func__, message, [&](const char* function) {
    require_all(function, {{"context", context}, {"a", a}, {"b", b}});
    QsComparison result = read_struct(comparison, {function, "comparison"});
    const Place place{a->memory, a->device, "a"};
    check_pictures(*a, *b, result, place);
    const Use use(*context->context, {function, "context"});
    result.psnr = result.psnr_8bit = result.ssim = result.flip = 0;
    result.lpips = result.lpips_paper = 0;
    if (place.is_gpu()) {
      use.require_gpu(place.device, {function, "a"});
      compare_on_gpu(*a, *b, use, result);
    }
    if (!place.is_gpu() || wants(result, QS_METRIC_FLIP | kLpips)) {
      ThreadPool& pool = use.pool();
      HostCopies copies(use, use.stream());
      const Image first = unit_image_of(copies.of(*a), pool);
      const Image second = unit_image_of(copies.of(*b), pool);
      if (!place.is_gpu()) compare_on_host(result.mask, first, second, pool, result);
      if (wants(result, QS_METRIC_FLIP)) result.flip = flip(first, second, pool);
      compare_features(*context->context, first, second, result);
    }
    write_struct(result, comparison, {function, "comparison"});
  });
}
