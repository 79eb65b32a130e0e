// SPDX-License-Identifier: MIT
//
// GL textures that the render thread draws into and the window shows, so that frames never leave
// the GPU. The render thread has its own GL context, which shares objects with the window's. A
// texture is taken, drawn into, shown and given back.
#pragma once

#include <algorithm>
#include <array>
#include <mutex>
#include <utility>

#include "raster/api/renderer.h"

struct GLFWwindow;

namespace qs {

class GlFrames {
 public:
  /// On the main thread. Makes a hidden window whose context shares objects with `window`. Throws
  /// Error(device).
  explicit GlFrames(GLFWwindow* window);
  ~GlFrames();

  /// On the render thread: makes the shared context current. unbind() also frees the textures.
  void bind();
  void unbind();

  /// On the render thread: an unused RGBA8 texture of this size, with storage for mipmaps.
  GlTexture take(int width, int height);

  /// On any thread, once the texture is no longer read.
  void give_back(const GlTexture& texture);

 private:
  struct Slot {
    GlTexture texture;
    int width = 0, height = 0;
    bool taken = false;
  };

  GLFWwindow* context_;
  std::mutex mutex_;
  unsigned versions_ = 0;
  // One each: prepared or drawn, waiting for the window, being taken by it, shown, shown before.
  std::array<Slot, 5> slots_;
};

/// Decides if a frame is drawn into a GL texture after frames for which that failed. A frame may
/// fail because memory was short for a moment, and on other machines it fails always. So it is
/// tried again, after more and more frames that went through host memory.
class InteropRetry {
 public:
  static constexpr int kFirstPause = 8, kLongestPause = 1024;  ///< frames

  /// True if the next frame is drawn into a texture. Call it once per frame.
  bool tries_next() { return left_ == 0 || --left_ == 0; }

  /// Returns true for the first failure after a frame that worked: the user has not heard of it.
  bool note_failure() {
    const bool is_first = pause_ == 0;
    pause_ = is_first ? kFirstPause : std::min(2 * pause_, kLongestPause);
    left_ = pause_;
    return is_first;
  }
  void note_success() { pause_ = 0; }

 private:
  int pause_ = 0, left_ = 0;  // frames; left_: until the next try
};

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
