// SPDX-License-Identifier: MIT
//
// The GL texture that the renderer prepares for the next frame while the window shows this one.
#pragma once

#include <utility>

#include "raster/api/renderer.h"

namespace qs {

/// `Frames` is GlFrames. No texture is lost if the renderer or `frames` throws.
template <class Frames>
class PreparedTexture {
 public:
  /// Prepares a texture for a frame of this size.
  void prepare(int width, int height, Frames& frames, Renderer& renderer) {
    texture_ = frames.take(width, height);
    width_ = width;
    height_ = height;
    renderer.prepare_target(texture_);
  }

  /// The prepared texture if it has this size, else another texture. The caller gives it back.
  GlTexture take(int width, int height, Frames& frames, Renderer& renderer) {
    if (texture_.name == 0) return frames.take(width, height);
    if (width == width_ && height == height_) return std::exchange(texture_, {});
    renderer.prepare_target(HostImage{});  // ends its use of the texture
    frames.give_back(std::exchange(texture_, {}));
    return frames.take(width, height);
  }

 private:
  GlTexture texture_;  // name 0: none
  int width_ = 0, height_ = 0;
};

}  // namespace qs
