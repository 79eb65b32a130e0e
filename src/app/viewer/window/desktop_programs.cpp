// SPDX-License-Identifier: MIT
#include "app/viewer/window/desktop_programs.h"

#include <fmt/format.h>

#include "app/viewer/state/actions.h"
#include "base/fail.h"

namespace qs {

void DesktopPrograms::open(const std::filesystem::path& path) {
  ChildCommand command;
  command.words = {opener_, path.string()};
  try {
    started_.emplace_back(path, command);
  } catch (const Error& error) {
    fail(ErrorKind::device, "{}: cannot be opened: {}", path.string(), error.what());
  }
}

void DesktopPrograms::take_reports(Actions& actions) {
  std::erase_if(started_, [&](Started& started) {
    const auto end = started.process.wait_for(std::chrono::milliseconds(0));
    if (end && !end->good()) {
      actions.push_back(
          call(action::notify_error, fmt::format("{}: cannot be opened: {} ended with {}",
                                                 started.path.string(), opener_, end->text())));
    }
    return end.has_value();
  });
}

}  // namespace qs
