// SPDX-License-Identifier: MIT
// Compiled alone: Boost takes long to compile, and it has macros of its own.
#include "app/serve/server.h"

#ifdef QUADSPLAT_SERVE
#include "app/serve/request.h"
#endif

#include "base/fail.h"

namespace qs {

#ifndef QUADSPLAT_SERVE

std::unique_ptr<Server> make_server(const ServeOptions& options) {
  fail(ErrorKind::device,
       "{}: this program was built without its web server: install libboost-dev and build it again",
       options.command);
}

#else

namespace {

using Tcp = asio::ip::tcp;

constexpr std::chrono::milliseconds kEndTurn{100};  ///< between two questions whether to end

class BeastServer : public Server {
 public:
  explicit BeastServer(const ServeOptions& options) : acceptor_(hub_.io), end_timer_(hub_.io) {
    hub_.options = options;
    if (!options.tls.key.empty()) hub_.tls.emplace(make_tls_context(options.tls, options.command));
    hub_.names = HostNames(options.address, options.name);
    error_code error;
    const auto address = asio::ip::make_address(options.address, error);
    if (error)
      fail(ErrorKind::usage, "{}: --address {}: not an address such as 127.0.0.1 or ::1",
           options.command, options.address);
    const Tcp::endpoint endpoint(address, static_cast<unsigned short>(options.port));
    try {
      acceptor_ = Tcp::acceptor(hub_.io, endpoint);
    } catch (const boost::system::system_error& problem) {
      fail(ErrorKind::device, "{}: {} port {} cannot be used: {}", options.command, options.address,
           options.port, problem.code().message());
    }
    if (options.sibr) sibr_listener_ = listen_for_sibr(*options.sibr);
  }

  int port() const override { return acceptor_.local_endpoint().port(); }
  std::vector<std::string> warnings() const override {
    std::vector<std::string> sentences;
    const ServeOptions& options = hub_.options;
    if (!hub_.tls && !acceptor_.local_endpoint().address().is_loopback())
      sentences.push_back(
          fmt::format("{} can be reached from other machines, and the connection is not encrypted: "
                      "ssh -L to 127.0.0.1 is safer, or --certificate and --key",
                      options.address));
    if (!hub_.tls) return sentences;
    const std::string problem = certificate_problem(*hub_.tls);
    if (!problem.empty())
      sentences.push_back(fmt::format("{}: --certificate {}: {}; browsers refuse it",
                                      options.command, options.tls.certificate.string(), problem));
    return sentences;
  }
  int sibr_port() const override { return sibr_listener_.port(); }
  const std::array<SentPictures, 4>& sent() const override { return hub_.sent; }

  void run(ServedScenes& scenes, const std::function<bool()>& ends,
           ServedTraining* training) override {
    hub_.training = training;
    for (const auto& scene : scenes) hub_.scenes.push_back(&scene->opened);
    {
      Pictures pictures(scenes, receiver());
      hub_.pictures = &pictures;
      std::optional<SibrServer> sibr;
      if (hub_.options.sibr)
        sibr.emplace(sibr_listener_, *hub_.options.sibr, pictures, *hub_.scenes.front());
      await_end(ends);
      hub_.io.run();
      hub_.pictures = nullptr;
    }
    hub_.io.restart();
  }

  /// An exception ended a handler of no visitor. The next turn tries again.
  void give_up() {}

 private:
  // The threads of Pictures report to the thread of the network.
  Pictures::Receiver receiver() {
    return {[this](int visitor) {
              tell(visitor, [](VisitorLink& link, double now) { link.picture_drawn(now); });
            },
            [this](int visitor, Picture picture) {
              tell(visitor, [picture = std::move(picture)](VisitorLink& link, double now) mutable {
                link.picture_ready(std::move(picture), now);
              });
            },
            [this](int visitor, Actions actions) {
              if (reported_by_training(visitor, actions)) return;
              tell(visitor, [actions = std::move(actions)](Visitor& one, double now) {
                if (actions.empty()) one.host().job_ended();
                one.apply(actions, now);
              });
            },
            [this](int visitor, int version, Measuring state) {
              tell(visitor, [version, state](Visitor& one, double now) {
                one.measuring_changed(version, state, now);
              });
            }};
  }

  // Reports an event to the visitor's connection on the thread of the network, if it still exists.
  template <class Tell>
  void tell(int visitor, Tell tell) {
    asio::post(hub_.io, [this, visitor, tell = std::move(tell)]() mutable {
      const auto found = hub_.live.find(visitor);
      if (found == hub_.live.end()) return;
      if (const std::shared_ptr<Live> live = found->second.lock()) live->handle(tell);
    });
  }

  void accept() {
    accepts_ = true;
    acceptor_.async_accept([this](error_code error, Tcp::socket socket) {
      accepts_ = !error;  // for example without file descriptors: the next turn tries again
      if (error) return;
      guarded(*this, [&] { begin(std::move(socket)); });
      accept();
    });
  }

  void begin(Tcp::socket socket) {
    error_code error;
    const auto remote = socket.remote_endpoint(error);
    if (error) return;
    socket.set_option(Tcp::no_delay(true), error);
    Place place = hub_.connections.enter(remote.address().to_string());
    if (!place) return;
    std::make_shared<Request>(hub_, std::move(socket), std::move(place))->begin();
  }

  // All visitors share the model of a training. The thread of the renderer calls this too.
  bool reported_by_training(int visitor, const Actions& actions) {
    if (hub_.training == nullptr || visitor != hub_.training->visitor()) return false;
    asio::post(hub_.io, [this, actions] {
      guarded(*this, [&] {
        hub_.training->job_reported(actions);
        tell_all(actions);
      });
    });
    return true;
  }
  void tell_all(const Actions& actions) {
    if (actions.empty()) return;
    const auto all = hub_.live;  // a visitor may leave meanwhile
    for (const auto& [number, weak] : all)
      if (const std::shared_ptr<Live> live = weak.lock())
        live->handle([&](Visitor& visitor, double now) { visitor.apply(actions, now); });
  }

  void await_end(const std::function<bool()>& ends) {
    bool is_over = false;
    guarded(*this, [&] {
      hub_.connections.prune(SteadyClock::now());
      if (hub_.training != nullptr)
        tell_all(hub_.training->follow(*hub_.pictures, !hub_.live.empty(), seconds_now()));
      is_over = ends();
      if (!is_over && !accepts_) accept();
    });
    if (is_over) {
      error_code ignored;
      acceptor_.close(ignored);
      hub_.io.stop();
      return;
    }
    end_timer_.expires_after(kEndTurn);
    end_timer_.async_wait([this, &ends](error_code error) {
      if (!error) await_end(ends);
    });
  }

  Hub hub_;
  Tcp::acceptor acceptor_;
  TcpSocket sibr_listener_;
  asio::steady_timer end_timer_;
  bool accepts_ = false;
};

}  // namespace

std::unique_ptr<Server> make_server(const ServeOptions& options) {
  return std::make_unique<BeastServer>(options);
}

#endif

}  // namespace qs
