// SPDX-License-Identifier: MIT
#include "app/serve/sibr_server.h"

#include <algorithm>
#include <future>
#include <memory>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "app/viewer/render/host_frames.h"
#include "raster/scene/image.h"

namespace qs {
namespace {

constexpr std::chrono::milliseconds kAcceptTime{200};  ///< between two looks for ended viewers
constexpr std::chrono::milliseconds kStopTime{50};     ///< between two looks for a stop
constexpr double kLeastSplatScale = 0.01, kMostSplatScale = 10;

std::string rgb_of(const std::vector<std::uint8_t>& rgba) {
  std::string rgb;
  rgb.reserve(rgba.size() / 4 * 3);
  for (std::size_t i = 0; i + 3 < rgba.size(); i += 4)
    for (std::size_t c = 0; c < 3; ++c) rgb += static_cast<char>(rgba[i + c]);
  return rgb;
}

std::string plain_picture(const SibrRequest& request, const glm::vec3& color) {
  const std::size_t pixels =
      static_cast<std::size_t>(request.width) * static_cast<std::size_t>(request.height);
  std::string rgb;
  rgb.reserve(3 * pixels);
  for (std::size_t i = 0; i < pixels; ++i)
    for (int c = 0; c < 3; ++c) rgb += static_cast<char>(to_8bit(color[c]));
  return rgb;
}

}  // namespace

TcpSocket listen_for_sibr(const SibrOptions& options) {
  return listen_on_loopback(options.port,
                            fmt::format("serve: --sibr-port {}: 127.0.0.1", options.port));
}

SibrServer::SibrServer(TcpSocket& listener, const SibrOptions& options, Pictures& pictures,
                       const OpenedScene& scene, std::size_t number)
    : listener_(listener),
      options_(options),
      pictures_(pictures),
      scene_(scene),
      number_(number),
      thread_([this](const std::stop_token& stop) { accept(stop); }) {}

void SibrServer::accept(const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    TcpSocket socket = listener_.accept(patience(kAcceptTime, stop));
    const std::lock_guard lock(mutex_);
    // An ended thread does not need the lock any more.
    std::erase_if(viewers_, [](const SibrViewer& viewer) { return viewer.ended; });
    if (!socket.is_open() || std::ssize(viewers_) >= options_.viewers) continue;
    SibrViewer& viewer = viewers_.emplace_back(std::move(socket));
    try {
      viewer.thread = std::jthread([this, &viewer](const std::stop_token& viewer_stop) {
        answer_all(viewer.socket, viewer_stop);
        const std::lock_guard ending(mutex_);
        viewer.socket.close();
        viewer.ended = true;
      });
    } catch (const std::system_error&) {  // the system gives no more threads
      viewers_.pop_back();
    }
  }
}

void SibrServer::answer_all(TcpSocket& socket, const std::stop_token& stop) {
  const int visitor = pictures_.new_visitor();
  try {
    while (const std::optional<SibrRequest> request = read_request(socket, stop)) {
      const std::string answer = picture_of(*request, visitor, stop) + with_length(options_.name);
      const auto bytes = std::as_bytes(std::span(answer));
      if (socket.write(bytes, patience(options_.silence, stop)) != TcpEnd::done) break;
    }
  } catch (...) {  // the viewer is closed
  }
  pictures_.forget(visitor);
}

std::optional<SibrRequest> SibrServer::read_request(TcpSocket& socket,
                                                    const std::stop_token& stop) const {
  const Patience whole = patience(options_.silence, stop);
  return read_sibr_request(
      [&](std::span<std::byte> bytes) { return socket.read(bytes, whole) == TcpEnd::done; });
}

// Throws if the viewer cannot be answered.
std::string SibrServer::picture_of(const SibrRequest& wish, int visitor,
                                   const std::stop_token& stop) {
  if (wish.width == 0 || wish.height == 0) return {};
  const std::optional<Camera> camera = camera_of(wish);
  if (!camera) return plain_picture(wish, scene_.settings.background);
  FrameRequest request;
  request.camera = *camera;
  request.settings = scene_.settings;
  const double scale = wish.splat_scale > 0 ? wish.splat_scale : 1;  // NaN: 1
  request.settings.splat_scale =
      static_cast<float>(std::clamp(scale, kLeastSplatScale, kMostSplatScale));
  const auto drawing = std::make_shared<std::packaged_task<std::string(RenderContext&)>>(
      [request](RenderContext& context) {
        return rgb_of(draw_on_host(context, request, request.camera).rgba);
      });
  std::future<std::string> rgb = drawing->get_future();
  pictures_.run(visitor, number_, [drawing](RenderContext& context) { (*drawing)(context); });
  while (rgb.wait_for(kStopTime) != std::future_status::ready)
    if (stop.stop_requested()) throw Cancelled();
  return rgb.get();
}

}  // namespace qs
