// SPDX-License-Identifier: MIT
//
// Shows a training in another program that speaks network_gui (3DGS and its descendants). Such a
// trainer reads one request per iteration and waits for it without end, so a silent viewer stops
// the training. While the user moves, requests follow each other without a pause; then the
// connection is closed, and opened every few seconds for one new picture. A paused training keeps
// its connection, because it goes on when that ends.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "app/remote/remote_run.h"
#include "app/remote/tcp.h"

namespace qs {

/// The view that the user wants to see.
struct RemoteView {
  Camera camera;
  int version = 0;  ///< names the picture
  double splat_scale = 1;
  bool is_moving = false;  ///< more views follow soon
};

struct RemotePicture {
  Camera camera;
  int version = 0, width = 0, height = 0;
  std::vector<std::uint8_t> rgba;  ///< rows from the top
  double ms = 0;                   ///< from the request to the picture
};

struct RemoteTimes {
  std::chrono::milliseconds first_word{200};   ///< a trainer that says nothing so long is INRIA's
  std::chrono::milliseconds visit{3000};       ///< between two connections while the view rests
  std::chrono::milliseconds pause_turn{100};   ///< between two requests of a paused training
  std::chrono::milliseconds connecting{5000};  ///< at most
  std::chrono::milliseconds silence{5000};     ///< without an answer, before the user is told
};

class RemoteTraining {
 public:
  /// Connects on a thread of its own. `wake` is called there when there is something to take. The
  /// end of this object closes the connection, which takes at most 50 ms.
  RemoteTraining(TcpAddress address, std::function<void()> wake, const RemoteTimes& times = {});

  void show(const RemoteView& view);
  void pause(bool paused);
  /// The newest picture, once.
  std::optional<RemotePicture> take_picture();
  RemoteRun run();

 private:
  using Clock = std::chrono::steady_clock;

  void loop(const std::stop_token& stop);
  bool is_due() const;  // a request; with the lock
  void visit(const std::stop_token& stop);
  bool open(const std::stop_token& stop);
  bool ask(const std::stop_token& stop);
  // False if the connection cannot be used any more; the user reads why.
  bool read(std::span<std::byte> bytes, const std::stop_token& stop);
  ReadBytes reader(const std::stop_token& stop);
  bool is_sound(SibrEnd end);
  void close_with(const std::string& problem);
  template <class Change>
  void change(Change&& change);

  const TcpAddress address_;
  const std::function<void()> wake_;
  const RemoteTimes times_;

  // Of the thread.
  TcpSocket socket_;
  SibrDialect dialect_ = SibrDialect::unknown;
  bool has_answered_ = false;  // on this connection

  std::mutex mutex_;  // guards everything below but the thread
  std::condition_variable_any changed_;
  std::optional<RemoteView> view_;
  int asked_version_ = -1;
  bool asked_paused_ = false;  // the last request paused the training
  Clock::time_point next_visit_{};
  std::optional<RemotePicture> picture_;
  RemoteRun run_;

  std::jthread thread_;
};

}  // namespace qs
