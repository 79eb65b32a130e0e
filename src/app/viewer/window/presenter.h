// SPDX-License-Identifier: MIT
//
// Shows frames in the window with OpenGL: the newest picture, with a map's colours over it or
// beside another one when it has them. Pixels come from the host or from a GL texture that the
// renderer drew into.
#pragma once

#include "app/viewer/render/gl_frames.h"
#include "app/viewer/render/render_thread.h"

namespace qs {

/// Values of cells over the picture, and the scale of their colours.
struct HeatLayer {
  int columns = 0, rows = 0, cell_px = 1;
  std::vector<float> values;  ///< rows * columns
  float maximum = 1;          ///< has the last colour
  bool has_signs = false;     ///< then -maximum has the first one, else 0
};
HeatLayer layer_of(const Heatmap& map, const Scale& scale);
HeatLayer layer_of(const PairDifference& difference, const Scale& scale);

class Presenter {
 public:
  /// In the window's GL context. Throws Error(device) when a shader is missing or does not compile.
  Presenter();
  ~Presenter();
  Presenter(const Presenter&) = delete;
  Presenter& operator=(const Presenter&) = delete;

  /// Makes the frame the one on show; `layer` is its heat map or, in a split window, what the view
  /// SplitView::tile_pairs shows. A GL texture must stay as it is until another frame was drawn.
  void show(FrameReply reply, std::optional<HeatLayer> layer);

  /// Fills the framebuffer. `split` matters while the frame has another one beside it.
  void draw(int width, int height, const Split& split);

  /// GPU time of a recent upload and draw, milliseconds; 0 until the first is known.
  float gpu_ms() const { return gpu_ms_; }

  /// Waits for the GPU.
  static void finish();

  /// Pixels of the framebuffer as they are, for screenshots.
  static Image grab(int width, int height);

 private:
  void upload();
  void upload_pixels(unsigned texture, const std::vector<std::uint8_t>& rgba) const;
  void upload_layer();
  void begin_timing();
  void end_timing();

  struct Uniforms {
    int split, flipped, divider, amplification, heat_low, heat_high, heat_cells;
  };

  std::optional<FrameReply> next_;  // shown and not yet uploaded
  std::optional<HeatLayer> layer_;  // of the frame on show
  unsigned program_ = 0, empty_vertices_ = 0;
  Uniforms uniforms_{};
  unsigned pixels_ = 0;  // a buffer: the way of pixels from the host
  unsigned picture_ = 0, other_ = 0, heat_ = 0, rising_colors_ = 0, signed_colors_ = 0;
  unsigned shown_ = 0;  // the texture with the frame
  int width_ = 0, height_ = 0;
  bool has_other_ = false;
  unsigned query_ = 0;
  bool timing_ = false, timed_ = false;
  float gpu_ms_ = 0;
};

}  // namespace qs
