// SPDX-License-Identifier: MIT
//
// The web server: the page by HTTP, pictures and state by WebSocket. One thread does the network
// and owns the visitors; pictures.h has the threads that render and encode.
#pragma once

#include <array>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/serve/connections.h"
#include "app/serve/picture_message.h"
#include "app/serve/served_scene.h"
#include "app/serve/sibr_server.h"

namespace qs {

class ServedTraining;

/// The files in PEM format with which the server encrypts its connections. Both may be the same
/// file.
struct TlsFiles {
  std::filesystem::path certificate;  ///< a chain, the server's first
  std::filesystem::path key;          ///< of the server's certificate, without a password
};

struct ServeOptions {
  std::string command = "serve";      ///< that messages name
  std::string address = "127.0.0.1";  ///< to listen at
  std::string name;                   ///< another name of the host in addresses; may be empty
  int port = 7007;                    ///< 0: any free one
  std::string token;                  ///< make_token()
  TlsFiles tls;                       ///< empty: nothing is encrypted
  std::optional<SibrOptions> sibr;    ///< answers INRIA's remote viewer too
  ServeLimits limits;
};

class Server {
 public:
  virtual ~Server() = default;

  virtual int port() const = 0;
  /// Sentences: other machines reach the address and nothing is encrypted, or browsers refuse the
  /// certificate because of its time. Usually none.
  virtual std::vector<std::string> warnings() const = 0;
  /// Of SIBR's viewers; 0 without them.
  virtual int sibr_port() const = 0;

  /// So far; index = PictureCodec. Not while run() runs on another thread.
  virtual const std::array<SentPictures, 4>& sent() const = 0;

  /// Serves until ends() is true, which it asks ten times a second. At least one scene. Throws
  /// Error. `training`: of the first scene; may be null.
  virtual void run(ServedScenes& scenes, const std::function<bool()>& ends,
                   ServedTraining* training) = 0;
};

/// A server that listens from now on, and answers from run() on. Throws Error if the address is
/// wrong or taken, if a file of TLS cannot be used, or if this build has no server.
std::unique_ptr<Server> make_server(const ServeOptions& options);

}  // namespace qs
