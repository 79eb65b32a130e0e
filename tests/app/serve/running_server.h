// SPDX-License-Identifier: MIT
//
// A server of small scenes on a thread of its own.
#pragma once

#include <array>
#include <atomic>
#include <memory>
#include <string>
#include <thread>

#include "app/serve/serve_scenes.h"
#include "app/serve/server.h"

namespace qs::test {

inline constexpr const char* kToken = "0123456789abcdef0123456789abcdef";

/// start() starts the server with `options`.
class RunningServer {
 public:
  RunningServer() {
    options.port = 0;
    options.token = kToken;
  }
  ~RunningServer() { end(); }
  RunningServer(const RunningServer&) = delete;
  RunningServer& operator=(const RunningServer&) = delete;

  /// Does nothing if it runs.
  void start() {
    if (!server_) start(small.scenes);
  }
  /// Serves other scenes, which outlive the server as the training does.
  void start(ServedScenes& scenes, ServedTraining* training = nullptr) {
    server_ = make_server(options);
    thread_ = std::thread([this, &scenes, training] {
      server_->run(
          scenes, [this] { return ends_.load(); }, training);
    });
  }
  void end() {
    ends_ = true;
    if (thread_.joinable()) thread_.join();
  }

  unsigned short port() {
    start();
    return static_cast<unsigned short>(server_->port());
  }
  int sibr_port() {
    start();
    return server_->sibr_port();
  }
  /// Ends the server.
  std::array<SentPictures, 4> sent() {
    end();
    return server_->sent();
  }
  /// For a Host field.
  std::string host() { return "127.0.0.1:" + std::to_string(port()); }

  ServeOptions options;
  SmallScenes small;

 private:
  std::unique_ptr<Server> server_;
  std::atomic<bool> ends_ = false;
  std::thread thread_;
};

}  // namespace qs::test
