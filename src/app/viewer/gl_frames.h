// SPDX-License-Identifier: MIT
//
// Pixel buffers in GL that the render thread draws into and the window shows, so that frames never
// leave the GPU. The render thread uses them through a GL context of its own that shares objects
// with the window's. A buffer is taken, drawn into, shown, given back.
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

  /// On the render thread: makes the shared context its own; unbind() also frees the buffers.
  void bind();
  void unbind();

  /// On the render thread: a buffer for width x height RGBA8 that nobody shows.
  GlBuffer take(int width, int height);

  /// On any thread, once nothing reads the buffer any more.
  void give_back(const GlBuffer& buffer);

 private:
  struct Slot {
    GlBuffer buffer;
    std::size_t bytes = 0;
    bool taken = false;
  };

  GLFWwindow* context_;
  std::mutex mutex_;
  unsigned versions_ = 0;
  std::array<Slot, 4> slots_;  // one drawn, one waiting, one shown, one whose copy may still run
};

}  // namespace qs
