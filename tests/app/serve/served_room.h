// SPDX-License-Identifier: MIT
//
// Visitors with the renderer that they share, as the server connects them, but without sockets.
#pragma once

#include <condition_variable>
#include <deque>
#include <memory>
#include <mutex>
#include <set>

#include "app/serve/serve_scenes.h"
#include "app/serve/sharing.h"

namespace qs::test {

class ServedRoom {
 public:
  SmallScenes small;
  double now = 100;
  std::vector<std::unique_ptr<Visitor>> visitors;  ///< visitor i has number i + 1
  std::vector<SentFile> files;                     ///< of all visitors
  std::vector<int> measured;                       ///< numbers of those who were measured, in order
  Sharing sharing;

  explicit ServedRoom(int count = 1, int scenes = 2, std::optional<int> budget = {})
      : small(scenes, budget) {
    for (int i = 0; i < count; ++i) add();
    pictures_ = std::make_unique<Pictures>(
        small.scenes, Pictures::Receiver{
                          [](int) {},
                          [this](int visitor, Picture picture) {
                            post(visitor, [picture = std::make_shared<Picture>(std::move(picture))](
                                              ServedRoom& room, int number) {
                              room.ordered_.erase(number);
                              room.of(number).picture_ready(*picture, room.now);
                            });
                          },
                          [this](int visitor, const Actions& actions) {
                            post(visitor, [actions](ServedRoom& room, int number) {
                              // As the server: an empty report is the end of a job.
                              if (actions.empty()) room.of(number).host().job_ended();
                              room.of(number).apply(actions, room.now);
                            });
                          },
                          [this](int visitor, int version, Measuring state) {
                            post(visitor, [version, state](ServedRoom& room, int number) {
                              if (state == Measuring::runs) room.measured.push_back(number);
                              room.of(number).measuring_changed(version, state, room.now);
                            });
                          }});
  }
  ~ServedRoom() { pictures_.reset(); }

  Visitor& add() {
    visitors.push_back(std::make_unique<Visitor>(small.opened, glm::ivec2(64, 48), now));
    return *visitors.back();
  }
  Visitor& of(int number) { return *visitors[static_cast<std::size_t>(number - 1)]; }
  const Viewer& viewer(int number = 1) { return of(number).viewer(); }
  Pictures& pictures() { return *pictures_; }

  template <class Body>
  void take(Body body, int number = 1) {
    of(number).take({1, std::move(body)}, now);
  }
  void command(const std::string& help, int number = 1) { take(message::Command{help}, number); }
  void set(const std::string& control, double value, std::size_t index = 0, int number = 1) {
    take(message::SetControl{control, value, index}, number);
  }

  /// Passes turns until the condition holds; false after 60 s.
  bool until(const std::function<bool()>& holds) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(60);
    while (!holds()) {
      if (std::chrono::steady_clock::now() > end) return false;
      turn();
    }
    return true;
  }

  void turn() {
    now += 0.02;
    for (std::size_t i = 0; i < visitors.size(); ++i) {
      Visitor& visitor = *visitors[i];
      const int number = static_cast<int>(i) + 1;
      visitor.tick(now);
      sharing.meet(visitor, now);
      pass_on_work(visitor, number, *pictures_);
      for (SentFile& file : visitor.host().take_files()) files.push_back(std::move(file));
      if (ordered_.contains(number)) continue;
      if (auto order = visitor.next_order()) {
        ordered_.insert(number);
        pictures_->order(number, std::move(*order));
      }
    }
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, std::chrono::milliseconds(5), [&] { return !posted_.empty(); });
    while (!posted_.empty()) {
      const auto [number, event] = std::move(posted_.front());
      posted_.pop_front();
      lock.unlock();
      event(*this, number);
      sharing.meet(of(number), now);  // at once, as the server does: crops count in their order
      lock.lock();
    }
  }

 private:
  using Event = std::function<void(ServedRoom& room, int number)>;

  void post(int number, Event event) {
    {
      const std::lock_guard lock(mutex_);
      posted_.emplace_back(number, std::move(event));
    }
    changed_.notify_all();
  }

  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<std::pair<int, Event>> posted_;
  std::set<int> ordered_;
  std::unique_ptr<Pictures> pictures_;
};

}  // namespace qs::test
