// SPDX-License-Identifier: MIT
#include "app/viewer/render/photograph_reader.h"

#include <utility>

#include "app/viewer/state/actions.h"
#include "io/camera/photographs.h"

namespace qs {

PhotographReader::PhotographReader(std::function<void()> wake) : reports_(std::move(wake)) {
  thread_ = std::jthread([this](const std::stop_token& stop) { serve(stop); });
}

void PhotographReader::read(Work work) {
  {
    const std::lock_guard lock(mutex_);
    wanted_ = std::move(work);
    reading_ = true;
  }
  changed_.notify_all();
}

void PhotographReader::serve(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  while (changed_.wait(lock, stop, [this] { return wanted_ != nullptr; })) {
    const Work work = std::exchange(wanted_, nullptr);
    lock.unlock();
    work(reports_);
    lock.lock();
    reading_ = wanted_ != nullptr;
  }
}

PhotographReader::Work read_camera_photograph(const std::filesystem::path& path) {
  return [path](ActionQueue& reports) {
    try {
      ThreadPool pool(1);
      ShownPhotograph photograph{
          path, std::make_shared<Image>(read_photograph(path, glm::vec3(0), 1, pool))};
      reports.report(action::photograph_opened, std::move(photograph));
    } catch (const std::exception& error) {
      reports.report(action::notify_error, std::string(error.what()));
    }
  };
}

}  // namespace qs
