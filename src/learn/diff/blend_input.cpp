// SPDX-License-Identifier: MIT
#include "learn/diff/blend_input.h"

#include "base/fail.h"
#include "learn/diff/gaussians.h"

namespace qs::diff {

template <class Real>
void BlendInput<Real>::check(const char* who, bool has_depth, bool wants_depth) const {
  if (channel_count < 1 || channel_count > kMostChannels) {
    fail(ErrorKind::usage, "{}: there are {} channels; the number must be 1 to {}", who,
         channel_count, kMostChannels);
  }
  if (!channels && channel_count != 3) {
    fail(ErrorKind::usage, "{}: the frame's colours have 3 channels, not {}", who, channel_count);
  }
  if (wants_depth && !has_depth)
    fail(ErrorKind::usage, "{}: depths are wanted, but the frame has no arrays for them", who);
}

template <class Real>
void BlendInput<Real>::check_frame(const char* who, const PictureSize& of_frame,
                                   int channels_of_frame) const {
  if (size.width == of_frame.width && size.height == of_frame.height &&
      channel_count == channels_of_frame)
    return;
  fail(ErrorKind::usage, "{}: the frame has {} x {} pixels and {} channels, not {} x {} and {}",
       who, of_frame.width, of_frame.height, channels_of_frame, size.width, size.height,
       channel_count);
}

template struct BlendInput<float>;
template struct BlendInput<double>;

}  // namespace qs::diff
