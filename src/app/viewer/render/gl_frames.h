// SPDX-License-Identifier: MIT
//
// Textures in GL that the render thread draws into and the window shows, so that frames never
// leave the GPU. The render thread uses them through a GL context of its own that shares objects
// with the window's. A texture is taken, drawn into, shown, given back.
#pragma once

#include <array>
#include <mutex>

#include "raster/renderer.h"

struct GLFWwindow;

namespace qs {

class GlFrames {
 public:
  /// On the main thread. Makes a hidden window that shares with `window`. Throws Error(device).
  explicit GlFrames(GLFWwindow* window);
  ~GlFrames();
  GlFrames(const GlFrames&) = delete;
  GlFrames& operator=(const GlFrames&) = delete;

  /// On the render thread: makes the shared context its own; unbind() also frees the textures.
  void bind();
  void unbind();

  /// On the render thread: a texture of width x height RGBA8, with room for mipmaps, that nobody
  /// shows.
  GlTexture take(int width, int height);

  /// On any thread, once nothing reads the texture any more.
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
  // One expected or drawn, one waiting, one that the window just takes, one shown, one shown a
  // moment ago.
  std::array<Slot, 5> slots_;
};

}  // namespace qs
