// SPDX-License-Identifier: MIT
//
// The forward pass of training: the frame of pipeline `classic`, with what the backward pass needs
// of every pixel. Tile lists are decided in single precision as in every frame, also when Real is
// double.
#pragma once

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

template <class Real>
struct ForwardFrame {
  using Splat = typename PixelMath<Real>::Splat;

  VisibleSlots visible;
  std::vector<Splat> splats;       ///< per slot
  std::vector<glm::vec2> half_px;  ///< per slot: half size of a box with all pixels that count
  DepthOrder order;
  TileLists lists;

  // Per pixel, row by row.
  std::vector<glm::vec<3, Real>> color;  ///< over the background, not clamped
  std::vector<Real> transmittance;       ///< behind the last Gaussian
  std::vector<std::uint32_t> last;       ///< entries of the tile's list up to the last blended one
};

/// Throws Cancelled, and Error(device) if the tile lists do not fit into memory.
template <class Real>
void forward(const StepView& view, const Parameters<Real>& parameters, ForwardFrame<Real>& frame);

/// The pixels of a tile that are inside the image.
struct TileBox {
  int x0, y0, width, height;

  static TileBox of(const StepView& view, std::size_t tile);

  /// Calls visit(x, y, i) for the pixels within `half` of `mean`; i counts the pixels of a full
  /// tile row by row.
  template <class Vec2, class Visit>
  void for_each_pixel(const Vec2& mean, glm::vec2 half, const Visit& visit) const {
    const auto x = static_cast<float>(mean.x) - static_cast<float>(x0);
    const auto y = static_cast<float>(mean.y) - static_cast<float>(y0);
    const Span columns{clamp_to_int(x - half.x, width), clamp_to_int(x + half.x + 1, width)};
    const Span rows{clamp_to_int(y - half.y, height), clamp_to_int(y + half.y + 1, height)};
    for (int row = rows.begin; row < rows.end; ++row) {
      for (int column = columns.begin; column < columns.end; ++column)
        visit(x0 + column, y0 + row, row * kTileSize + column);
    }
  }
};

/// A Gaussian's covariance on the image in px^2.
template <class Real>
struct ImageCovariance {
  Covariance2<Real> before, after;  ///< without and with the dilation

  static ImageCovariance of(const View<Real>& view, const glm::vec<3, Real>& point,
                            const Covariance3<Real>& sigma, double dilation) {
    const Covariance2<Real> c = project_covariance(view, point, sigma);
    return {c, {c.xx + static_cast<Real>(dilation), c.xy, c.yy + static_cast<Real>(dilation)}};
  }
};

}  // namespace qs::cpu::train
