// SPDX-License-Identifier: MIT
//
// Opens files in the desktop's programs for them, through xdg-open.
#pragma once

#include <filesystem>
#include <list>
#include <string>

#include "app/viewer/state/action.h"
#include "base/child_process.h"

namespace qs {

class DesktopPrograms {
 public:
  /// `opener`: the program that is called with the path of the file.
  explicit DesktopPrograms(std::string opener = "xdg-open") : opener_(std::move(opener)) {}

  /// Starts to open a file or a folder. Throws Error(device) if the opener cannot be started.
  void open(const std::filesystem::path& path);

  /// Appends a message for every file that could not be opened since the last call.
  void take_reports(Actions& actions);

  bool busy() const { return !started_.empty(); }

 private:
  struct Started {
    Started(std::filesystem::path file, const ChildCommand& command)
        : path(std::move(file)), process(command) {}
    std::filesystem::path path;
    ChildProcess process;
  };

  std::string opener_;
  std::list<Started> started_;
};

}  // namespace qs
