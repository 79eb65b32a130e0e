// SPDX-License-Identifier: MIT
//
// The reduced resolution of a slow backend while the camera moves, and the steps back to the full
// resolution. A frame reduced by n has 1/n of the full frame's pixels along each side.
#pragma once

#include "raster/api/renderer.h"

namespace qs {

inline constexpr int kMostDivisor = 6;

/// The settings of a frame of Camera::reduced(). Its low-pass dilation covers the same part of the
/// window as the full frame's, so that Gaussians keep their extent and the picture keeps its
/// brightness.
RenderSettings reduced(RenderSettings settings, int divisor);

/// The longest time of a moving frame for which `divisor` is not increased: 28 ms for 1 and 2,
/// which leaves time for window and input at 30 pictures per second; 50 ms from 3 on.
double longest_moving_ms(int divisor);

struct FrameCost {
  double ms = 0;
  double pixels_ms = 0;  ///< the part of the frame's time that depends on the pixels
};

FrameCost cost_of(const RenderStats& stats);

/// Chooses the divisor from the costs of finished frames. The divisor grows when its frames are
/// certainly too slow. It shrinks when frames with a smaller divisor would certainly need at most
/// 80 % of their limit, so at constant costs it does not alternate. It grows beyond 3 only if that
/// may save a quarter of a frame's time. A single frame that another program disturbs changes
/// nothing.
class Resolution {
 public:
  /// The cost of a frame that was reduced by `divisor`.
  void learn(int divisor, const FrameCost& cost);

  /// The divisor for the next frame of a moving camera.
  int divisor() const { return divisor_; }

 private:
  int divisor_ = 1;
  int slow_ = 0, quick_ = 0;  // frames in a row that call for a larger or a smaller divisor
};

/// The divisor of the next frame when the camera rests and the window shows a frame reduced by
/// `divisor`: 3, then 2, then 1.
int refined(int divisor);

}  // namespace qs
