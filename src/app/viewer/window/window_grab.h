// SPDX-License-Identifier: MIT
//
// Writes a picture of the window, panels included, when it is drawn next.
#pragma once

#include <filesystem>
#include <functional>

#include "app/viewer/state/action.h"
#include "raster/scene/image.h"

namespace qs {

class WindowGrab {
 public:
  /// `notify`: notify the user once it is written.
  void request(const std::filesystem::path& path, bool notify);
  bool requested() const { return !path_.empty(); }

  /// Writes `pixels()` if a picture was requested; appends the message for the user to `actions`.
  void take(const std::function<Image()>& pixels, Actions& actions);

 private:
  std::filesystem::path path_;
  bool notify_ = false;
};

}  // namespace qs
