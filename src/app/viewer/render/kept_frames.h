// SPDX-License-Identifier: MIT
//
// The last two finished pictures that differ in their mode only, so that the window shows the other
// mode at once when the user switches back and forth. Pictures in GL textures are not kept: the GPU
// draws them in less time than the window needs.
#pragma once

#include <deque>

#include "app/viewer/render/render_context.h"

namespace qs {

class KeptFrames {
 public:
  /// Takes a copy of a finished full-size frame. Frames of another picture are dropped.
  void keep(const FrameRequest& request, const RenderedFrame& frame);

  /// The kept frame of this request if its mode is not the mode of the last frame; the same mode is
  /// requested twice only to draw it again. Empty if the request asks for counts that the frame
  /// lacks.
  std::optional<RenderedFrame> find(const FrameRequest& request) const;

 private:
  struct Kept {
    int picture = -1;
    RenderedFrame frame;
  };
  std::deque<Kept> frames_;  // the last drawn frame is the last
};

}  // namespace qs
