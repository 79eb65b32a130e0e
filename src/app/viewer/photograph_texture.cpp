// SPDX-License-Identifier: MIT
#include "app/viewer/photograph_texture.h"

#include <chrono>
#include <vector>

#include <epoxy/gl.h>

#include "app/photographs.h"
#include "app/viewer/window.h"

namespace qs {

PhotographTexture::~PhotographTexture() {
  if (texture_ != 0) glDeleteTextures(1, &texture_);
}

void PhotographTexture::show(const std::filesystem::path& path) {
  if (path == path_) return;
  path_ = path;
  next_ = std::async(std::launch::async, [path] {
    ThreadPool pool(1);
    Image image = read_photograph(path, glm::vec3(0), 1, pool);
    Window::wake();
    return image;
  });
}

void PhotographTexture::poll(PanelMemory& memory) {
  if (!next_.valid() || next_.wait_for(std::chrono::seconds(0)) != std::future_status::ready)
    return;
  const Image image = next_.get();
  std::vector<std::uint8_t> rgb(image.values.size());
  for (std::size_t i = 0; i < rgb.size(); ++i) rgb[i] = to_8bit(image.values[i]);
  if (texture_ == 0) glGenTextures(1, &texture_);
  glBindTexture(GL_TEXTURE_2D, texture_);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glTexImage2D(GL_TEXTURE_2D, 0, GL_RGB8, image.width, image.height, 0, GL_RGB, GL_UNSIGNED_BYTE,
               rgb.data());
  memory.photograph = texture_;
  memory.photograph_path = path_;
  memory.photograph_aspect = static_cast<double>(image.width) / std::max(image.height, 1);
}

}  // namespace qs
