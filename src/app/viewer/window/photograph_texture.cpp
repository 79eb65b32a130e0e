// SPDX-License-Identifier: MIT
#include "app/viewer/window/photograph_texture.h"

#include <chrono>

#include "app/session/photographs.h"
#include "app/viewer/window/window.h"

namespace qs {

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
  memory.photograph = texture_.show(image);
  memory.photograph_path = path_;
  memory.photograph_aspect = static_cast<double>(image.width) / std::max(image.height, 1);
}

}  // namespace qs
