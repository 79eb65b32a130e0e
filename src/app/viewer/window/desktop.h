// SPDX-License-Identifier: MIT
//
// The desktop: its dialog for opening files, and its programs for them.
#pragma once

#include <atomic>
#include <condition_variable>
#include <filesystem>
#include <functional>
#include <list>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "app/viewer/render/action_queue.h"
#include "app/viewer/state/action.h"
#include "base/child_process.h"

namespace qs {

/// The desktop's own dialog for opening a file or a folder, which xdg-desktop-portal shows in a
/// separate window. A thread communicates with the portal over D-Bus, so that the viewer never
/// waits. Without a session bus, a portal or support in this build, the dialog is not available.
class DesktopDialog {
 public:
  /// Begins to look for a portal, until the end of this object, which closes the dialog. `wake` is
  /// called on the dialog's thread after every report.
  explicit DesktopDialog(std::function<void()> wake);

  /// True once a portal was found that has the dialog for this choice, until it fails.
  bool is_available(Choosing choosing) const { return available_ && portal_has(choosing); }

  /// Shows the dialog in `folder` unless it is open. The chosen path is reported as
  /// action::path_chosen, a failure of the portal by opening the viewer's own dialog.
  void show(const std::filesystem::path& folder, Choosing choosing);

  void take_reports(Actions& actions) { reports_.take(actions); }

 private:
  /// A dialog that is or will be open.
  struct Wanted {
    std::filesystem::path folder;
    Choosing choosing;
  };

  void serve(const std::stop_token& stop);
  // Portals choose folders since version 3 of their interface.
  bool portal_has(Choosing choosing) const { return !chooses_folder(choosing) || version_ >= 3; }

  ActionQueue reports_;
  std::atomic<bool> available_ = false;
  std::atomic<unsigned> version_ = 0;  // the portal's interface has this version
  std::mutex mutex_;
  std::condition_variable_any changed_;
  std::optional<Wanted> wanted_;
  std::jthread thread_;
};

/// Puts a PNG file on the clipboard through wl-copy (Wayland) or xclip (X11). False if neither is
/// installed and works. Throws Error(input) if the file cannot be read.
bool copy_picture(const std::filesystem::path& file);

/// Opens files in the desktop's programs for them, through xdg-open.
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
