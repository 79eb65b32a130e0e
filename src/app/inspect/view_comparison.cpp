// SPDX-License-Identifier: MIT
#include "app/inspect/view_comparison.h"

#include <algorithm>

#include "app/picture/image_difference.h"

namespace qs {
namespace {

/// Summed-area table: entry (x, y) is the sum of all values above and left of that corner.
class SumTable {
 public:
  template <class Value>
  SumTable(int width, int height, const Value& value)
      : stride_(static_cast<std::size_t>(width) + 1),
        sums_(stride_ * (static_cast<std::size_t>(height) + 1)) {
    for (int y = 0; y < height; ++y) {
      double row = 0;
      for (int x = 0; x < width; ++x) {
        row += value(x, y);
        sums_[index(x + 1, y + 1)] = sums_[index(x + 1, y)] + row;
      }
    }
  }

  double of(const PixelBox& box) const {
    return sums_[index(box.x1, box.y1)] - sums_[index(box.x0, box.y1)] -
           sums_[index(box.x1, box.y0)] + sums_[index(box.x0, box.y0)];
  }

 private:
  std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y) * stride_ + static_cast<std::size_t>(x);
  }

  std::size_t stride_;
  std::vector<double> sums_;
};

}  // namespace

ViewVariant draw_variant(Renderer& renderer, const Camera& camera, const RenderSettings& settings,
                         std::string name, const Image& truth, std::stop_token stop) {
  Outputs outputs;
  outputs.used = settings.mode != kReferenceMode;
  const Frame& frame = renderer.render(camera, settings, outputs, HostImage{}, std::move(stop));
  const ImageDifference difference = image_difference(frame.color, truth);
  return {std::move(name), frame.color, frame.stats, difference.psnr, difference.largest, {}};
}

PixelBox most_different_crop(const Image& truth, const std::vector<ViewVariant>& variants,
                             glm::ivec2 size) {
  const int width = std::min(size.x, truth.width), height = std::min(size.y, truth.height);
  constexpr int kStep = 4;  // pixels between candidate positions
  PixelBox best{(truth.width - width) / 2, (truth.height - height) / 2, 0, 0};
  double most = 0;
  for (const ViewVariant& variant : variants) {
    const SumTable squares(truth.width, truth.height, [&](int x, int y) {
      double sum = 0;
      for (int c = 0; c < 3; ++c) {
        const double d = difference_8bit(variant.color, truth, x, y, c);
        sum += d * d;
      }
      return sum;
    });
    for (int y = 0; y + height <= truth.height; y += kStep) {
      for (int x = 0; x + width <= truth.width; x += kStep) {
        const double sum = squares.of({x, y, x + width, y + height});
        if (sum <= most) continue;
        most = sum;
        best = {x, y, 0, 0};
      }
    }
  }
  return {best.x0, best.y0, best.x0 + width, best.y0 + height};
}

glm::ivec2 default_crop_size(int width, int height) {
  return {std::max(width / 5, 16), std::max(height / 5, 16)};
}

}  // namespace qs
