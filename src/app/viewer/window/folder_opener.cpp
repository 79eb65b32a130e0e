// SPDX-License-Identifier: MIT
#include "app/viewer/window/folder_opener.h"

#include <chrono>
#include <utility>

#include <fmt/format.h>

#include "app/viewer/state/actions.h"
#include "raster/base/error.h"

namespace qs {

void FolderOpener::open(const std::filesystem::path& folder) {
  folder_ = folder;
  failed_ = false;
  try {
    child_.emplace(ChildCommand{.words = {"xdg-open", folder.string()}, .own_group = true});
  } catch (const Error&) {
    child_.reset();
    failed_ = true;
  }
}

void FolderOpener::take_report(Actions& actions) {
  if (child_) {
    const std::optional<ChildEnd> end = child_->wait_for(std::chrono::milliseconds(0));
    if (!end) return;
    child_.reset();
    failed_ = !end->good();
  }
  if (!std::exchange(failed_, false)) return;
  actions.push_back(call(action::notify_error,
                         fmt::format("xdg-open does not open the folder: {}", folder_.string())));
}

}  // namespace qs
