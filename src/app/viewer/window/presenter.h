// SPDX-License-Identifier: MIT
//
// Draws the newest frame into the window with OpenGL, with the colours of a map over it or beside
// another frame. Pixels come from host memory or from a GL texture that the renderer drew into.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>

#include "app/viewer/render/gl_frames.h"
#include "app/viewer/render/render_thread.h"
#include "app/viewer/state/action.h"
#include "base/not_copied.h"
#include "raster/scene/image.h"

namespace qs {

/// A map over the picture: values of its cells and the range of their colours.
struct HeatLayer {
  int columns = 0, rows = 0, cell_px = 1;
  std::vector<float> values = {};  ///< rows * columns
  float low = 0, high = 1;         ///< the values with the first and the last colour
};

/// The maps of a frame: of the picture, of the other side of a split window, and the difference of
/// their pairs. Each is unset if the frame does not have it.
struct HeatLayers {
  std::optional<HeatLayer> picture, other, difference;
};
HeatLayers layers_of(const ShownFrame& shown);

/// The part of `area` that a picture of `aspect` (width / height) fills; the rest stays dark.
PixelBox fitted(const PixelBox& area, double aspect);

/// The filter that enlarges a frame with fewer pixels than the window.
enum class Enlarging { linear, cubic };

/// Cubic; linear if the CPU emulates OpenGL, because it needs its time for the frames.
Enlarging suitable_enlarging();

class Presenter : NotCopied {
 public:
  /// In the window's GL context. Throws Error(device) if a shader is missing or does not compile.
  explicit Presenter(Enlarging enlarging = suitable_enlarging());
  ~Presenter();

  /// Draws this frame from now on. Its GL texture, if any, is given back to `frames` once a later
  /// frame was drawn; `frames` may be null if frames never have a texture.
  void show(RenderedFrame frame, GlFrames* frames);

  /// Draws no frame until the next show().
  void clear();

  /// Fills a part of the framebuffer, which has `window` pixels; a frame of another aspect fills
  /// what fits. `split` is used if the frame has a second frame beside it.
  void draw(glm::ivec2 window, const PixelBox& area, const Split& split, const HeatStyle& style);

  /// GPU time of a recent upload and draw, milliseconds; 0 until one was measured.
  float gpu_ms() const { return gpu_ms_; }

  /// Waits for the GPU.
  static void finish();

  /// The pixels of the framebuffer.
  static Image grab(int width, int height);

 private:
  void upload();
  void upload_pixels(unsigned texture, const std::vector<std::uint8_t>& rgba) const;
  bool has_layers() const { return layers_.picture || layers_.other || layers_.difference; }
  int uniform(const char* name) const;  // its place in present.frag
  void set_up_layers(bool cubic, const Split& split, const HeatStyle& style);
  void set_up_heat(const Split& split, const HeatStyle& style);
  void begin_timing();
  void end_timing();

  Enlarging enlarging_;
  std::optional<RenderedFrame> next_;  // not yet uploaded
  HeatLayers layers_;                  // maps of the newest frame
  GlTexture newest_, previous_;        // textures that are not given back yet
  unsigned frame_program_ = 0, program_ = 0, empty_vertices_ = 0;
  unsigned pixels_ = 0;  // buffer for uploads
  unsigned picture_ = 0, other_ = 0, heat_ = 0, other_heat_ = 0, difference_ = 0;
  unsigned rising_colors_ = 0, signed_colors_ = 0;
  HeatColors colors_ = HeatColors::viridis;  // the scheme in rising_colors_
  unsigned shown_ = 0;                       // texture of the frame
  int width_ = 0, height_ = 0;
  double aspect_ = 1;  // the full-size view's width / height
  bool has_other_ = false;
  unsigned query_ = 0;
  bool timing_ = false, timed_ = false;
  float gpu_ms_ = 0;
};

/// A texture with a picture for panels, in the window's GL context.
class PictureTexture : NotCopied {
 public:
  ~PictureTexture();

  /// The GL texture with this picture (height x width x 3), uploaded if the picture has changed
  /// since the last call; 0 if it is null.
  unsigned show(const std::shared_ptr<const Image>& image);

 private:
  std::shared_ptr<const Image> image_;
  unsigned texture_ = 0;
};

/// Writes a picture of the window, panels included, when it is drawn next.
class WindowGrab {
 public:
  /// `notify`: notify the user once it is written.
  void request(const std::filesystem::path& path, bool notify);
  bool requested() const { return !path_.empty(); }

  /// Writes `pixels()` if a picture was requested; appends the message for the user to `actions`.
  /// `altered`: of the file's metadata, if it is not empty.
  void take(const std::function<Image()>& pixels, Actions& actions,
            const std::string& altered = {});

 private:
  std::filesystem::path path_;
  bool notify_ = false;
};

}  // namespace qs
