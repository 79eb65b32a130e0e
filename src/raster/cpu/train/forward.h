// SPDX-License-Identifier: MIT
//
// The forward pass of training: the frame of pipeline `classic`, with the values of every pixel
// that the backward pass needs. Tile lists are decided in single precision as in every frame, also
// when Real is double.
#pragma once

#include <cmath>
#include <stop_token>
#include <vector>

#include "raster/cpu/classic/bin.h"
#include "raster/cpu/train/parameters.h"
#include "raster/kernel/splat64.h"

namespace qs::cpu::train {

/// The view of one training step.
struct StepView {
  const Camera& camera;
  /// mode, sh_degree, background, antialiased (unset = no) and dilation are used.
  const RenderSettings& settings;
  ThreadPool& pool;
  std::stop_token stop = {};

  TileGrid grid() const { return TileGrid::of_image(camera.width, camera.height); }
  bool antialiased() const { return settings.antialiased.value_or(false); }
};

/// Conservative bound of the pixels with alpha >= 1/255, row by row: it may include others.
struct PixelArea {
  glm::vec2 mean_px, half_px;  ///< a box around the mean
  float slope;                 ///< in row dy the middle is at dx = slope dy
  float gamma;                 ///< pixels count where a dx^2 + 2 b dx dy + c dy^2 <= gamma
  float by_row, by_column;     ///< 1 / variance of y, and 1 / a

  static PixelArea of(const Footprint& footprint);

  /// Columns of row y.
  float low(float y, float half) const { return mean_px.x + slope * (y - mean_px.y) - half; }
  float high(float y, float half) const { return mean_px.x + slope * (y - mean_px.y) + half; }
  /// Half the length of row y in pixels; < 0 if no pixel of the row counts.
  float half_length(float y) const {
    const float dy = y - mean_px.y;
    const float rest = gamma - dy * dy * by_row;
    return rest > 0 ? std::sqrt(rest * by_column) + 1 : -1;
  }
};

/// The pixels of a tile that are inside the image.
struct TileBox {
  int x0, y0, width, height;

  static TileBox of(const StepView& view, std::size_t tile);

  /// Calls visit(x, y, i) for the pixels of the area; i counts the pixels of a full tile row by
  /// row.
  template <class Visit>
  void for_each_pixel(const PixelArea& area, const Visit& visit) const {
    const auto left = static_cast<float>(x0), top = static_cast<float>(y0);
    const float y = area.mean_px.y - top;
    const int end = clamp_to_int(y + area.half_px.y + 1, height);
    for (int row = clamp_to_int(y - area.half_px.y, height); row < end; ++row) {
      const float row_y = top + static_cast<float>(row);
      const float half = area.half_length(row_y);
      if (half < 0) continue;
      const int last = clamp_to_int(area.high(row_y, half) - left + 1, width);
      for (int x = clamp_to_int(area.low(row_y, half) - left, width); x < last; ++x)
        visit(x0 + x, y0 + row, row * kTileSize + x);
    }
  }
};

template <class Real>
struct ForwardFrame {
  using Splat = typename PixelMath<Real>::Splat;

  VisibleSlots visible;               ///< listed in a tile by the culling mode
  std::vector<std::uint8_t> in_view;  ///< per Gaussian, see Gradients::visible
  std::vector<std::uint8_t> listed;   ///< per Gaussian: 1 if the culling mode lists it in a tile
  std::vector<Splat> splats;          ///< per slot
  std::vector<PixelArea> areas;       ///< per slot
  DepthOrder order;
  TileLists lists;

  // Per pixel, row by row.
  std::vector<glm::vec<3, Real>> color;  ///< over the background, not clamped
  std::vector<Real> transmittance;       ///< behind the last Gaussian
  std::vector<std::uint32_t> last;  ///< entries of the tile's list up to the last blended entry
};

/// Throws Cancelled, and Error(device) if the tile lists do not fit into memory.
/// `field`: the colours, in place of coefficients; may be null.
template <class Real>
void forward(const StepView& view, const Parameters<Real>& parameters, ForwardFrame<Real>& frame,
             const FieldGradient<Real>* field = nullptr);

}  // namespace qs::cpu::train
