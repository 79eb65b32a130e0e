// SPDX-License-Identifier: MIT
//
// GL textures that the render thread draws into and the window shows, so that frames never leave
// the GPU. The render thread has its own GL context, which shares objects with the window's. A
// texture is taken, drawn into, shown and given back.
#pragma once

#include <array>
#include <mutex>

#include "raster/api/renderer.h"

struct GLFWwindow;

namespace qs {

class GlFrames {
 public:
  /// On the main thread. Makes a hidden window whose context shares objects with `window`. Throws
  /// Error(device).
  explicit GlFrames(GLFWwindow* window);
  ~GlFrames();
  GlFrames(const GlFrames&) = delete;
  GlFrames& operator=(const GlFrames&) = delete;

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

}  // namespace qs
