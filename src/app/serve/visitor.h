// SPDX-License-Identifier: MIT
//
// A visitor: a Viewer of their own with the window's input and commands, and the pictures that it
// needs next. Without sockets and threads; times are seconds of one clock.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "app/serve/message.h"
#include "app/serve/pictures.h"
#include "app/serve/quality.h"
#include "app/viewer/commands/input.h"
#include "app/viewer/render/resolution.h"
#include "app/viewer/state/action.h"

namespace qs {

/// The requests of a visitor's actions: jobs are kept, everything else is refused.
class VisitorHost : public Host {
 public:
  std::vector<Job> take_jobs() { return std::exchange(jobs_, {}); }

  void open(const std::filesystem::path&, const std::string&) override { refuse(); }
  void open_beside(const std::filesystem::path&) override { refuse(); }
  void read_photograph(const std::filesystem::path&) override { refuse(); }
  void read_test_photograph(const std::shared_ptr<const TestViews>&, std::size_t) override {
    refuse();
  }
  void cancel_loading() override {}
  void run(Job job) override;
  void stop_job() override {}
  void run_behind(Job) override {}
  void start_training(const TrainingRequest&) override { refuse(); }
  void train(TrainingCommand) override { refuse(); }
  void write_file(const std::filesystem::path&, const std::string&) override { refuse(); }
  void grab_window(const std::filesystem::path&, bool) override { refuse(); }
  void open_with_desktop(const std::filesystem::path&) override { refuse(); }
  std::string clipboard() const override { return {}; }
  void set_clipboard(const std::string&) override { refuse(); }
  void toggle_fullscreen() override {}
  void quit() override { refuse(); }

 private:
  [[noreturn]] static void refuse();

  std::vector<Job> jobs_;
};

class Visitor {
 public:
  /// Shows the first of the scenes, which must outlive this object. `size`: of the picture.
  Visitor(const std::vector<const OpenedScene*>& scenes, glm::ivec2 size, double now);

  /// Every message but Hello and Received.
  void take(const ClientMessage& message, double now);
  /// Moves what moves. Called at every turn while is_busy().
  void tick(double now);
  void apply(const Actions& actions, double now);

  /// Something moves, or a picture at rest will be due soon.
  bool is_busy() const;
  /// True if the picture of the last order is out of date, so that it need not be finished.
  bool has_moved_on() const { return viewer().version != ordered_version_; }

  /// The picture that is needed now. The caller asks only when it can be sent, over a line of this
  /// rate in bits per second; 0: not known yet.
  std::optional<PictureOrder> next_order(double line_rate = 0);
  /// The answer to the last order, also if it is empty.
  void picture_ready(const Picture& picture, double now);

  std::vector<Job> take_jobs() { return host_.take_jobs(); }

  const Viewer& viewer() const { return store_.viewer(); }
  std::size_t scene() const { return scene_; }

 private:
  void show_scene(std::size_t scene);
  bool waits_for_rest() const;
  bool rests() const;

  const std::vector<const OpenedScene*>& scenes_;
  std::size_t scene_ = 0;
  ViewerStore store_;
  VisitorHost host_;
  Input input_;
  Resolution resolution_;
  Quality quality_;
  double began_ = 0, last_tick_ = 0;
  std::uint32_t last_input_ = 0;
  int ordered_version_ = -1;
  bool ordered_lossless_ = false;
};

}  // namespace qs
