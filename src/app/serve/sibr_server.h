// SPDX-License-Identifier: MIT
//
// Answers INRIA's remote viewer (SIBR_remoteGaussian) at 127.0.0.1. Its viewers take turns at the
// renderer with the visitors of the page: each picture is a short job of Pictures. A thread per
// viewer, because a viewer waits for every answer.
#pragma once

#include <chrono>
#include <list>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <thread>

#include "app/remote/sibr_message.h"
#include "app/remote/tcp.h"
#include "app/serve/pictures.h"

namespace qs {

struct SibrOptions {
  int port = 6009;  ///< 0: any free one
  /// ASCII text that follows each picture. The viewer opens it as a path of its machine.
  std::string name;
  int viewers = 4;  ///< at most; more are closed
  /// For a request to be complete and for an answer to leave, else the viewer is closed.
  std::chrono::milliseconds silence{10'000};
};

/// Throws Error(device) if the port is taken.
TcpSocket listen_for_sibr(const SibrOptions& options);

class SibrServer {
 public:
  /// Answers with pictures of the scene until the end of this object. `listener`: listens. All must
  /// outlive it. `number`: the scene's in Pictures.
  SibrServer(TcpSocket& listener, const SibrOptions& options, Pictures& pictures,
             const OpenedScene& scene, std::size_t number = 0);

 private:
  struct SibrViewer {
    TcpSocket socket;
    bool ended = false;  // guarded by mutex_
    std::jthread thread = {};
  };

  void accept(const std::stop_token& stop);
  void answer_all(TcpSocket& socket, const std::stop_token& stop);
  std::optional<SibrRequest> read_request(TcpSocket& socket, const std::stop_token& stop) const;
  std::string picture_of(const SibrRequest& request, int visitor, const std::stop_token& stop);

  TcpSocket& listener_;
  SibrOptions options_;
  Pictures& pictures_;
  const OpenedScene& scene_;
  std::size_t number_;
  std::mutex mutex_;
  std::list<SibrViewer> viewers_;
  std::jthread thread_;  // uses everything above, so it ends first
};

}  // namespace qs
