// SPDX-License-Identifier: MIT
//
// The photograph over the picture: read on a thread of its own, since some formats take long.
#pragma once

#include <filesystem>
#include <future>

#include "app/viewer/panels/panels.h"
#include "app/viewer/window/picture_texture.h"

namespace qs {

class PhotographTexture {
 public:
  /// Starts reading unless it is the one on show.
  void show(const std::filesystem::path& path);

  /// Puts a picture that was read into PanelMemory. In the window's GL context. Throws Error when
  /// it could not be read.
  void poll(PanelMemory& memory);

  bool reading() const { return next_.valid(); }

 private:
  PictureTexture texture_;
  std::filesystem::path path_;
  std::future<Image> next_;
};

}  // namespace qs
