// SPDX-License-Identifier: MIT
//
// Shows frames in the window with OpenGL: the newest picture, with the heat map's colours when it
// has one. Pixels come from the host or from a GL texture that the renderer drew into.
#pragma once

#include "app/viewer/gl_frames.h"
#include "app/viewer/render_thread.h"

namespace qs {

class Presenter {
 public:
  /// In the window's GL context. Throws Error(device) when a shader is missing or does not compile.
  Presenter();
  ~Presenter();
  Presenter(const Presenter&) = delete;
  Presenter& operator=(const Presenter&) = delete;

  /// Makes the frame the one on show; `scale` belongs to its heat map. A GL texture must stay
  /// as it is until another frame was drawn.
  void show(FrameReply reply, const Scale& scale);

  /// Fills the framebuffer.
  void draw(int width, int height);

  /// GPU time of a recent upload and draw, milliseconds; 0 until the first is known.
  float gpu_ms() const { return gpu_ms_; }

  /// Waits for the GPU.
  static void finish();

  /// Pixels of the framebuffer as they are, for screenshots.
  static Image grab(int width, int height);

 private:
  void upload();
  void begin_timing();
  void end_timing();

  std::optional<FrameReply> next_;  // shown and not yet uploaded
  unsigned program_ = 0, empty_vertices_ = 0;
  int heat_maximum_uniform_ = -1, heat_cells_uniform_ = -1;
  unsigned pixels_ = 0;  // a buffer: the way of pixels from the host
  unsigned picture_ = 0, heat_ = 0, colors_ = 0;
  unsigned shown_ = 0;  // the texture with the frame
  int width_ = 0, height_ = 0;
  float heat_maximum_ = 0;
  glm::vec2 heat_cells_{1.0f};
  unsigned query_ = 0;
  bool timing_ = false, timed_ = false;
  float gpu_ms_ = 0;
};

}  // namespace qs
