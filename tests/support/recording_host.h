// SPDX-License-Identifier: MIT
//
// A Host for tests without a window: it records the requests of actions.
#pragma once

#include <map>
#include <vector>

#include "app/viewer/state/action.h"
#include "app/viewer/state/training.h"

namespace qs::test {

class RecordingHost : public Host {
 public:
  struct Opened {
    std::filesystem::path path;
    std::string axes;
  };
  std::vector<Opened> opened;
  std::vector<std::filesystem::path> opened_beside, photographs, grabs, pictures, opened_outside;
  std::map<std::filesystem::path, std::string> written;
  std::vector<Job> jobs, jobs_behind;
  std::vector<std::size_t> test_photographs;
  std::vector<TrainingCommand> training;
  std::vector<TrainingRequest> trained;
  int cancelled = 0, stopped = 0, fullscreens = 0, quits = 0;
  std::string text;  ///< on the clipboard
  bool copies_pictures = false;
  std::vector<std::filesystem::path> copied;  ///< pictures, if copies_pictures

  void open(const std::filesystem::path& path, const std::string& axes) override {
    opened.push_back({path, axes});
  }
  void open_beside(const std::filesystem::path& path) override { opened_beside.push_back(path); }
  void read_photograph(const std::filesystem::path& path) override { photographs.push_back(path); }
  void read_test_photograph(const std::shared_ptr<const TestViews>&, std::size_t view) override {
    test_photographs.push_back(view);
  }
  void cancel_loading() override { ++cancelled; }
  void run(Job job) override { jobs.push_back(std::move(job)); }
  void stop_job() override { ++stopped; }
  void run_behind(Job job) override { jobs_behind.push_back(std::move(job)); }
  void start_training(const TrainingRequest& request) override { trained.push_back(request); }
  void train(TrainingCommand command) override { training.push_back(command); }
  void write_file(const std::filesystem::path& path, const std::string& content) override {
    written[path] = content;
  }
  void grab_window(const std::filesystem::path& path, bool) override { grabs.push_back(path); }
  void grab_picture(const std::filesystem::path& path) override { pictures.push_back(path); }
  void open_with_desktop(const std::filesystem::path& path) override {
    opened_outside.push_back(path);
  }
  std::string clipboard() const override { return text; }
  void set_clipboard(const std::string& content) override { text = content; }
  bool copy_picture(const std::filesystem::path& file) override {
    if (copies_pictures) copied.push_back(file);
    return copies_pictures;
  }
  void toggle_fullscreen() override { ++fullscreens; }
  void quit() override { ++quits; }
};

}  // namespace qs::test
