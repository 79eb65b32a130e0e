// SPDX-License-Identifier: MIT
//
// The metrics of two pictures.
#include <algorithm>
#include <cstdint>
#include <vector>

#include "learn/lpips/metric.h"
#include "library/check/arrays.h"
#include "library/check/context.h"
#include "library/check/structs.h"
#include "raster/scene/image_metrics.h"

using namespace qs::library;

namespace {

constexpr Types kPictures = kReals | kBytes;
constexpr std::int64_t kMostValues = std::int64_t{1} << 29;  // the limit for files of pictures, too
constexpr std::uint32_t kAllMetrics = QS_METRIC_PSNR | QS_METRIC_PSNR_8BIT | QS_METRIC_SSIM |
                                      QS_METRIC_FLIP | QS_METRIC_LPIPS | QS_METRIC_LPIPS_PAPER;
constexpr std::uint32_t kLpips = QS_METRIC_LPIPS | QS_METRIC_LPIPS_PAPER;

void check_pictures(const QsArray& a, const QsArray& b, const QsComparison& comparison) {
  const Where of_a{"qs_compare", "a"}, of_b{"qs_compare", "b"};
  const Where where{"qs_compare", "comparison"};
  check_dimensions(a, of_a, 3);
  const std::int64_t height = a.sizes[0], width = a.sizes[1];
  if (height < 1 || width < 1) refuse(of_a, "has no pixel: it is {} x {}", width, height);
  if (std::max(height, width) > kMostValues || height * width * 3 > kMostValues)
    refuse(of_a, "{} x {} pixels are too many", width, height);
  check_array(a, of_a, {height, width, 3}, kPictures, Access::reads);
  check_array(b, of_b, {height, width, 3}, kPictures, Access::reads);
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
  check_array(comparison.mask, where / "mask", {height, width}, kBytes, Access::reads);
  if ((comparison.metrics & ~(QS_METRIC_PSNR | QS_METRIC_SSIM)) != 0)
    refuse(where / "mask", "belongs to QS_METRIC_PSNR and QS_METRIC_SSIM alone");
}

Image unit_image_of(const QsArray& array, ThreadPool& pool) {
  Image image = image_of(array, pool);
  clamp_to_unit(image);
  return image;
}

/// Sets the distances that are asked for.
void compare_features(Context& context, const Image& a, const Image& b, QsComparison& comparison) {
  const auto wants = [&](std::uint32_t metric) { return (comparison.metrics & metric) != 0; };
  comparison.lpips = comparison.lpips_paper = 0;
  if (!wants(kLpips)) return;
  const lpips::Weights weights = read_lpips(comparison.lpips_weights);
  const int side = lpips::smallest_side(*weights.network);
  if (std::min(a.width, a.height) < side)
    refuse({"qs_compare", "a"}, "has {} x {} pixels, and LPIPS with {} needs {} x {} at least",
           a.width, a.height, weights.network->name, side, side);
  const LpipsDistance distance =
      make_lpips(context.backend(), weights, context.pool(), context.device());
  if (wants(QS_METRIC_LPIPS)) comparison.lpips = distance(a, b, lpips::InputRange::symmetric);
  if (wants(QS_METRIC_LPIPS_PAPER))
    comparison.lpips_paper = distance(a, b, lpips::InputRange::unit);
}

}  // namespace

int32_t qs_compare(QsContext* context, const QsArray* a, const QsArray* b, QsComparison* comparison,
                   char* message) {
  return library::call(__func__, message, [&](const char* function) {
    require_all(function, {{"context", context}, {"a", a}, {"b", b}});
    QsComparison result = read_struct(comparison, {function, "comparison"});
    check_pictures(*a, *b, result);
    const Use use(*context->context, {function, "context"});
    ThreadPool& pool = use.pool();
    const Image first = unit_image_of(*a, pool), second = unit_image_of(*b, pool);
    std::vector<std::uint8_t> mask;
    if (!is_absent(result.mask)) {
      mask.resize(first.values.size() / 3);
      gather(result.mask, pool, mask.data(),
             [](auto value) { return static_cast<std::uint8_t>(value); });
    }
    const auto wants = [&](std::uint32_t metric) { return (result.metrics & metric) != 0; };
    const SsimBorder border =
        result.ssim_border == QS_BORDER_ZEROS ? SsimBorder::zeros : SsimBorder::crop;
    result.psnr = wants(QS_METRIC_PSNR) ? psnr(first, second, pool, mask) : 0;
    result.psnr_8bit = wants(QS_METRIC_PSNR_8BIT) ? psnr_8bit(first, second) : 0;
    result.ssim = wants(QS_METRIC_SSIM) ? ssim(first, second, pool, border, mask) : 0;
    result.flip = wants(QS_METRIC_FLIP) ? flip(first, second, pool) : 0;
    compare_features(*context->context, first, second, result);
    write_struct(result, comparison, {function, "comparison"});
  });
}
