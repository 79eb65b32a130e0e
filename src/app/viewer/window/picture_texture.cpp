// SPDX-License-Identifier: MIT
#include "app/viewer/window/picture_texture.h"

#include <vector>

#include <epoxy/gl.h>

namespace qs {

PictureTexture::~PictureTexture() {
  if (texture_ != 0) glDeleteTextures(1, &texture_);
}

unsigned PictureTexture::show(const std::shared_ptr<const Image>& image) {
  if (image == nullptr || image == image_) return image == nullptr ? 0 : texture_;
  image_ = image;
  std::vector<std::uint8_t> rgb(image->values.size());
  for (std::size_t i = 0; i < rgb.size(); ++i) rgb[i] = to_8bit(image->values[i]);
  if (texture_ == 0) glGenTextures(1, &texture_);
  glBindTexture(GL_TEXTURE_2D, texture_);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_LINEAR);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glTexImage2D(GL_TEXTURE_2D, 0, GL_RGB8, image->width, image->height, 0, GL_RGB, GL_UNSIGNED_BYTE,
               rgb.data());
  glGenerateMipmap(GL_TEXTURE_2D);
  return texture_;
}

}  // namespace qs
