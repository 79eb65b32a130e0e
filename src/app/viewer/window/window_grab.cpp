// SPDX-License-Identifier: MIT
#include "app/viewer/window/window_grab.h"

#include <system_error>

#include "app/viewer/state/actions.h"
#include "base/error.h"
#include "io/picture/image_file.h"

namespace qs {

void WindowGrab::request(const std::filesystem::path& path, bool notify) {
  path_ = path;
  notify_ = notify;
}

void WindowGrab::take(const std::function<Image()>& pixels, Actions& actions) {
  if (!requested()) return;
  const std::filesystem::path path = std::exchange(path_, {});
  try {
    std::error_code ignored;  // write_image() reports a missing folder
    std::filesystem::create_directories(path.parent_path(), ignored);
    write_image(pixels(), path);
    if (notify_) actions.push_back(call(action::notify_file, path, std::string()));
  } catch (const Error& error) {
    actions.push_back(call(action::notify_error, std::string(error.what())));
  }
}

}  // namespace qs
