// SPDX-License-Identifier: MIT
//
// The reduced resolution of a slow backend while the camera moves, and the steps back to the full
// one. A frame reduced by n has 1/n of the full frame's pixels along each side.
#pragma once

#include "raster/renderer.h"

namespace qs {

inline constexpr int kMostDivisor = 8;

/// The camera of a reduced frame. Every point of the view keeps its place in the window.
Camera reduced(const Camera& camera, int divisor);

/// The settings of a reduced frame. Its low-pass dilation covers the same part of the window as the
/// full frame's, so that Gaussians keep their extent and the picture keeps its brightness.
RenderSettings reduced(RenderSettings settings, int divisor);

/// The longest time of a moving frame that is reduced by `divisor` and not more: 28 ms for 1 and 2,
/// so that window and input have time left in 30 pictures a second; 50 ms from 3 on.
double longest_moving_ms(int divisor);

/// Chooses the divisor from the times of finished frames. A frame reduced by m instead of n < m
/// takes at least (n/m)^2 of the time, and not more. A divisor is left for a larger one if its
/// frames are certainly too slow, and for a smaller one if its frames certainly need at most 80 % of
/// their limit. So a divisor that was too slow is not tried again at the same costs. Single frames
/// that other programs disturb do not count.
class Resolution {
 public:
  /// A frame that was reduced by `divisor` took `ms`.
  void learn(int divisor, double ms);

  /// The divisor for the next frame of a moving camera.
  int divisor() const { return divisor_; }

 private:
  int divisor_ = 1;
  int slow_ = 0, quick_ = 0;  // frames in a row that call for a larger or a smaller divisor
};

/// The divisor of the next frame when the camera rests and the window shows one reduced by
/// `divisor`: 3, then 2, then 1.
int refined(int divisor);

}  // namespace qs
