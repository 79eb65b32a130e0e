// SPDX-License-Identifier: MIT
//
// The reduced resolution of a slow backend while the camera moves, and the steps back to the full
// one. A frame reduced by n has 1/n of the full frame's pixels along each side.
#pragma once

#include "raster/renderer.h"

namespace qs {

inline constexpr int kMostDivisor = 8;
/// A slower frame is reduced more, up to kUsualDivisor.
inline constexpr double kMovingFrameMs = 28;
/// Beyond kUsualDivisor a frame is reduced only if it takes longer than this: 20 a second.
inline constexpr double kSlowestFrameMs = 50;
inline constexpr int kUsualDivisor = 3;
/// A frame is reduced less if it would then take at most this part of its limit.
inline constexpr double kFinerShare = 0.8;

/// The camera of a reduced frame. Every point of the view keeps its place in the window.
Camera reduced(const Camera& camera, int divisor);

/// The settings of a reduced frame. Its low-pass dilation covers the same part of the window as the
/// full frame's, so that Gaussians keep their extent and the picture keeps its brightness.
RenderSettings reduced(RenderSettings settings, int divisor);

/// Chooses the divisor from the times of finished frames. Pixels are a part of a frame's cost, so a
/// frame reduced by m instead of n < m takes at least (n/m)^2 of the time. For constant costs the
/// divisor therefore comes to rest: it never returns to one that was too slow.
class Resolution {
 public:
  /// A frame that was reduced by `divisor` took `ms`.
  void learn(int divisor, double ms);

  /// The divisor for the next frame of a moving camera.
  int divisor() const { return divisor_; }

 private:
  int divisor_ = 1;
};

/// The divisor of the next frame when the camera rests and the window shows one reduced by
/// `divisor`: 3, then 2, then 1.
int refined(int divisor);

}  // namespace qs
