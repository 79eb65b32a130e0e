// SPDX-License-Identifier: MIT
//
// A picture of the host as a texture that panels show. In the window's GL context.
#pragma once

#include "raster/scene/image.h"

namespace qs {

class PictureTexture {
 public:
  PictureTexture() = default;
  ~PictureTexture();
  PictureTexture(const PictureTexture&) = delete;
  PictureTexture& operator=(const PictureTexture&) = delete;

  /// Replaces the picture, height x width x 3; returns the texture's name, 0 for an empty picture.
  unsigned show(const Image& image);

 private:
  unsigned texture_ = 0;
};

}  // namespace qs
