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
#include "app/serve/picture_message.h"
#include "app/serve/quality.h"
#include "app/viewer/commands/input.h"
#include "app/viewer/render/frame_requests.h"
#include "app/viewer/render/resolution.h"
#include "app/viewer/state/action.h"

namespace qs {

struct VisitorJob {
  Job job;
  bool is_long = false;  ///< Host::run_long
};

/// The requests of a visitor's actions: jobs and files are kept, everything else is refused.
class VisitorHost : public Host {
 public:
  std::vector<VisitorJob> take_jobs() {
    open_ += jobs_.size();
    return std::exchange(jobs_, {});
  }
  /// A job that was taken has ended.
  void job_ended() { open_ -= open_ > 0 ? 1 : 0; }
  /// True if another job is taken. Else run() throws Error.
  bool has_room() const;
  /// True if the visitor's long jobs are to be stopped.
  bool take_stop() { return std::exchange(stops_, false); }
  std::vector<SentFile> take_files() { return std::exchange(files_, {}); }
  std::vector<TrainingCommand> take_training_commands() {
    return std::exchange(training_commands_, {});
  }

  void open(const std::filesystem::path&, const std::string&) override { refuse(); }
  void open_beside(const std::filesystem::path&) override { refuse(); }
  void read_photograph(const std::filesystem::path&) override { refuse(); }
  void read_test_photograph(const std::shared_ptr<const TestViews>&, std::size_t) override {
    refuse();
  }
  void cancel_loading() override { stops_ = true; }
  void run(Job job) override { keep({std::move(job), false}); }
  void run_long(Job job) override { keep({std::move(job), true}); }
  void stop_job() override { stops_ = true; }
  void run_behind(Job) override {}
  void start_training(const TrainingRequest&) override { refuse(); }
  void train(TrainingCommand command) override;
  void write_file(const std::filesystem::path& path, const std::string& text) override {
    send_file(path.filename().string(), std::make_shared<const std::string>(text));
  }
  void send_file(const std::string& name, std::shared_ptr<const std::string> bytes) override;
  void grab_window(const std::filesystem::path&, bool) override { refuse(); }
  void grab_picture(const std::filesystem::path&) override { refuse(); }
  void open_with_desktop(const std::filesystem::path&) override { refuse(); }
  std::string clipboard() const override { return {}; }
  void set_clipboard(const std::string&) override { refuse(); }
  void toggle_fullscreen() override {}
  void quit() override { refuse(); }

 private:
  [[noreturn]] static void refuse();
  void keep(VisitorJob job);

  std::vector<VisitorJob> jobs_;
  std::size_t open_ = 0;  // jobs that were taken and have not ended
  std::vector<SentFile> files_;
  std::vector<TrainingCommand> training_commands_;
  bool stops_ = false;
};

/// The shared parts of a scene as a visitor has them.
struct Met {
  CropRequest asked;  ///< the last request that was answered
  Backend backend = Backend::cpu;
};

/// What to do about the measuring of a visitor's table.
struct MeasuringWish {
  bool stops = false;  ///< the last request is out of date
  std::optional<NumbersRequest> request = {};
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

  /// The picture that is needed now. The caller asks only when it can be sent, over this line.
  std::optional<PictureOrder> next_order(const LineSpeed& line = {});
  /// The answer to the last order, also if it is empty.
  void picture_ready(const Picture& picture, double now);

  /// Called after every change.
  MeasuringWish measuring_wish();
  /// The request with this view version is measured now, waits, or was answered.
  void measuring_changed(int version, Measuring state, double now);
  Measuring measuring() const { return measuring_; }

  /// Jobs, files and commands for the owner to take.
  VisitorHost& host() { return host_; }

  /// The shared parts at the last Sharing::meet().
  const Met& met() const { return met_; }
  void set_met(Met met) { met_ = std::move(met); }

  const Viewer& viewer() const { return store_.viewer(); }
  std::size_t scene() const { return scene_; }

 private:
  void show_scene(std::size_t scene);
  void stop_long_jobs();
  void show_view(const message::ShowView& view);
  void do_all(const Actions& actions);
  bool waits_for_rest() const;
  bool rests() const;
  bool is_moved() const;  // by the visitor, by a flight or by playback

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
  CountingPace counting_pace_;
  int asked_numbers_ = -1;  // NumbersRequest::version of the last request; -1: none is open
  Measuring measuring_ = Measuring::none;
  Met met_;
};

/// Gives the renderer the jobs and measurements that the visitor's actions ask for. `number`: of
/// the visitor in `pictures`.
void pass_on_work(Visitor& visitor, int number, Pictures& pictures);

}  // namespace qs
