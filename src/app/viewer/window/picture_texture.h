// SPDX-License-Identifier: MIT
//
// A texture with a picture for panels, in the window's GL context.
#pragma once

#include <memory>

#include "raster/scene/image.h"

namespace qs {

class PictureTexture {
 public:
  PictureTexture() = default;
  ~PictureTexture();
  PictureTexture(const PictureTexture&) = delete;
  PictureTexture& operator=(const PictureTexture&) = delete;

  /// The GL texture with this picture (height x width x 3), uploaded if the picture has changed
  /// since the last call; 0 if it is null.
  unsigned show(const std::shared_ptr<const Image>& image);

 private:
  std::shared_ptr<const Image> image_;
  unsigned texture_ = 0;
};

}  // namespace qs
