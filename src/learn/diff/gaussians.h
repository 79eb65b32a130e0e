// SPDX-License-Identifier: MIT
//
// The arrays between the passes of the differentiable rasterizer, in the caller's memory:
//
//   inputs -> project -> boundary -> blend -> pictures
//
// and the derivatives by all of them, from the right to the left. Real is float, or double to check
// gradients.
#pragma once

#include <cstddef>
#include <cstdint>
#include <type_traits>

#include <glm/mat4x3.hpp>
#include <glm/vec3.hpp>

#include "learn/diff/strided_arrays.h"
#include "raster/kernel/blend.h"
#include "raster/kernel/hd.h"
#include "raster/kernel/tile_grid.h"

namespace qs::diff {

inline constexpr int kMostChannels = 32;

/// Gaussians with activated values. One with a number that is not finite is not drawn.
template <class Real>
struct GaussianInputs {
  std::size_t count = 0;
  Rows<const Real> means;        ///< 3, world units
  Rows<const Real> scales;       ///< 3 standard deviations, world units
  Rows<const Real> rotations;    ///< quaternions w, x, y, z
  Rows<const Real> covariances;  ///< xx, xy, xz, yy, yz, zz in place of scales and rotations
  Rows<const Real> opacities;    ///< 1; sensible values are 0..1
  ShRows<const Real> sh;         ///< (sh_degree + 1)^2 coefficients of colour
  int sh_degree = 0;             ///< 0..3
  Rows<const Real> channels;     ///< `channel_count` in place of coefficients; any values
  int channel_count = 3;         ///< 1..kMostChannels; 3 with coefficients

  /// Throws Error(usage), in a sentence that starts with `who`, if arrays are missing or given
  /// twice.
  void check(const char* who) const;
  /// Throws such an Error if a frame has another number of Gaussians.
  void check_frame(const char* who, std::size_t of_frame) const;
};

/// The values that pixels read of a Gaussian, and its radii on the image. Rows of Gaussians behind
/// the near plane or with a footprint that is degenerate or not finite are 0; there are also rows
/// of Gaussians that no tile lists.
template <class Real>
struct Boundary {
  Rows<Real> mean_px;  ///< 2; pixel i has its centre at coordinate i
  Rows<Real> conic;    ///< 3: a, b, c
  Rows<Real> depth;    ///< 1: view z
  Rows<Real> opacity;  ///< 1: with compensation
  Rows<Real> color;    ///< 3, of coefficients; given channels have no row here
  /// project() adds it to mean_px, unless it is 0 or a radius is 0.
  std::remove_const_t<Real> mean_offset{0};

  template <class U>
  requires(std::is_same_v<U, const Real> && !std::is_const_v<Real>) QS_HD operator Boundary<U>()
      const {
    return {mean_px, conic, depth, opacity, color, mean_offset};
  }
  /// Sets the rows of a Gaussian to 0.
  QS_HD void clear(std::size_t i) const {
    mean_px.fill(i, 2, 0);
    conic.fill(i, 3, 0);
    depth.fill(i, 1, 0);
    opacity.fill(i, 1, 0);
    color.fill(i, 3, 0);
  }
};

/// Derivatives by the boundary.
template <class Real>
struct BoundaryGradients {
  Boundary<Real> by;
  Rows<Real> channels;  ///< derivative by the given channels
  /// 2: the sums over pixels of the absolute values of the pixels' parts of by.mean_px (AbsGS, Ye
  /// et al. 2024, arXiv 2404.10484)
  Rows<Real> absolute_px;
  Real* background = nullptr;  ///< a number per channel
};

struct PictureSize {
  int width, height;

  TileGrid grid() const { return TileGrid::of_image(width, height); }
  std::size_t tiles() const { return static_cast<std::size_t>(grid().count()); }
  std::size_t pixels() const {
    return static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  }
  std::size_t pixel(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
           static_cast<std::size_t>(x);
  }
};

/// The inputs of blend() and blend_backward() beside the frame.
template <class Real>
struct BlendInput {
  PictureSize size;
  PixelRules<Real> rules;
  int channel_count = 3;
  Rows<const Real> channels;  ///< channels of the Gaussians; not given: their colours in the frame
  const Real* background = nullptr;  ///< a number per channel; null: 0

  /// Throws Error(usage), in a sentence that starts with `who`. `has_depth`: the frame has depths;
  /// `wants_depth`: a picture needs them.
  void check(const char* who, bool has_depth, bool wants_depth) const;
  /// Throws such an Error if the frame has another size or number of channels.
  void check_frame(const char* who, const PictureSize& of_frame, int channels_of_frame) const;
};

/// Derivatives by the inputs of project(); all rows of wanted arrays are written. The derivative by
/// xy, xz or yz of a covariance counts both equal elements of the matrix.
template <class Real>
struct InputGradients {
  Rows<Real> means, scales, rotations, covariances, opacities;
  ShRows<Real> sh;
};

/// Derivatives by the camera, whose matrix and position are independent of each other here.
struct PoseGradient {
  glm::dmat4x3 view_from_world{0.0};
  glm::dvec3 position{0.0};  ///< through the directions of colours
};

/// Pictures with `channel_count` channels in color and one channel in the others.
template <class Real>
struct Pictures {
  Pixels<Real> color;          ///< over the background, not clamped
  Pixels<Real> alpha;          ///< 1 - transmittance
  Pixels<Real> depth;          ///< sum of z by weight: alpha times the transmittance in front of it
  Pixels<Real> inverse_depth;  ///< sum of 1 / z by weight

  template <class U>
  requires(std::is_same_v<U, const Real> && !std::is_const_v<Real>) QS_HD operator Pictures<U>()
      const {
    return {color, alpha, depth, inverse_depth};
  }
};

}  // namespace qs::diff
