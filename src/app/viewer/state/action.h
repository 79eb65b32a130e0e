// SPDX-License-Identifier: MIT
//
// An action is a change of the Viewer that is carried out later: input, panels and threads collect
// actions, and ViewerStore::apply() runs them one by one on the main thread. Any function of the
// form f(Viewer&, arguments...) or f(Viewer&, Host&, arguments...) can be an action.
//
// A Host carries out the requests that actions can make to the program around the Viewer: files,
// background jobs, the window. The window's loop implements it, tests record the calls. Nothing
// here waits or changes the Viewer: outcomes arrive later as actions.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "app/viewer/state/viewer.h"

namespace qs {

struct RenderContext;
enum class TrainingCommand;
struct TestViews;
struct TrainingRequest;

/// Work for the render thread, which owns the renderer and the scene.
using Job = std::function<void(RenderContext&)>;

/// The requests of actions, see above.
class Host {
 public:
  virtual ~Host() = default;

  /// Starts reading a scene, cameras or a camera path. `axes`: ReadOptions::axes.
  virtual void open(const std::filesystem::path& path, const std::string& axes) = 0;
  /// Starts reading a scene to show beside the scene in the window.
  virtual void open_beside(const std::filesystem::path& path) = 0;
  virtual void read_photograph(const std::filesystem::path& path) = 0;
  virtual void read_test_photograph(const std::shared_ptr<const TestViews>& views,
                                    std::size_t view) = 0;
  virtual void cancel_loading() = 0;  ///< stops reading and the running job

  virtual void run(Job job) = 0;  ///< after the jobs that are already queued
  /// The same for a job that calls RenderContext::give_way between its parts.
  virtual void run_long(Job job) { run(std::move(job)); }
  virtual void stop_job() = 0;  ///< the running job
  /// Stops a film or a zoom; `keeps` it as far as it got.
  virtual void leave_job(bool /*keeps*/) { stop_job(); }
  /// Writes the results that could not be written below this folder.
  virtual void save_results(const std::filesystem::path& /*folder*/) {}
  /// When no frame is wanted. A frame or a job cancels it; a job that still waits is replaced.
  virtual void run_behind(Job job) = 0;

  virtual void start_training(const TrainingRequest& request) = 0;
  virtual void train(TrainingCommand command) = 0;  ///< for the training run, if there is one

  /// Throws Error(input).
  virtual void write_file(const std::filesystem::path& path, const std::string& text) = 0;

  /// Gives a file to a user at another machine, see Viewer::is_remote.
  virtual void send_file(const std::string& /*name*/,
                         std::shared_ptr<const std::string> /*bytes*/) {}

  /// Writes the window, panels included, as a picture after it is drawn next; then notifies the
  /// user if `notify`.
  virtual void grab_window(const std::filesystem::path& path, bool notify) = 0;
  /// Writes the picture of a training in another program as it came; then notifies the user. Throws
  /// Error if there is none yet.
  virtual void grab_picture(const std::filesystem::path& path) = 0;
  /// Opens a file or a folder in the desktop's program for it.
  virtual void open_with_desktop(const std::filesystem::path& path) = 0;
  virtual std::string clipboard() const = 0;
  virtual void set_clipboard(const std::string& text) = 0;
  /// Puts a PNG file on the clipboard as a picture. False if no program on this machine can.
  virtual bool copy_picture(const std::filesystem::path& /*file*/) { return false; }
  virtual void toggle_fullscreen() = 0;
  virtual void quit() = 0;
};

using Action = std::function<void(Viewer&, Host&)>;
using Actions = std::vector<Action>;

/// The action that calls `function` with these arguments after the viewer (and the host), or a
/// member function of the host.
template <class Function, class... Arguments>
Action call(Function function, Arguments... arguments) {
  return [function, ... kept = std::move(arguments)](Viewer& viewer, Host& host) {
    if constexpr (std::is_invocable_v<Function, Viewer&, Host&, const Arguments&...>) {
      function(viewer, host, kept...);
    } else if constexpr (std::is_member_function_pointer_v<Function>) {
      std::invoke(function, host, kept...);
    } else {
      function(viewer, kept...);
    }
  };
}

/// Owns the Viewer: everything may read it, and only actions change it.
class ViewerStore {
 public:
  explicit ViewerStore(Viewer viewer) : viewer_(std::move(viewer)) {}

  const Viewer& viewer() const { return viewer_; }

  /// An Error that the action throws is shown to the user.
  void apply(const Action& action, Host& host);

 private:
  Viewer viewer_;
};

}  // namespace qs
