// SPDX-License-Identifier: MIT
#include "app/remote/remote_training.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <new>
#include <utility>

#include <fmt/format.h>

namespace qs {
namespace {

constexpr std::size_t kMostText = 65536;  ///< of a trainer's texts, bytes
constexpr std::size_t kLengthBytes = 4;
constexpr const char* kOtherProtocol =
    "{}: the answer is not a training's: does another program listen there?";

std::vector<std::uint8_t> rgba_of(std::span<const std::byte> rgb) {
  std::vector<std::uint8_t> rgba(rgb.size() / 3 * 4, 255);
  for (std::size_t i = 0; i < rgb.size() / 3; ++i) {
    for (std::size_t c = 0; c < 3; ++c)
      rgba[4 * i + c] = std::to_integer<std::uint8_t>(rgb[3 * i + c]);
  }
  return rgba;
}

}  // namespace

RemoteTraining::RemoteTraining(TcpAddress address, std::function<void()> wake,
                               const RemoteTimes& times)
    : address_(std::move(address)), wake_(std::move(wake)), times_(times) {
  run_.address = address_.text;
  thread_ = std::jthread([this](const std::stop_token& stop) { loop(stop); });
}

RemoteTraining::~RemoteTraining() = default;

void RemoteTraining::show(const RemoteView& view) {
  {
    const std::lock_guard lock(mutex_);
    view_ = view;
  }
  changed_.notify_all();
}

void RemoteTraining::pause(bool paused) {
  {
    const std::lock_guard lock(mutex_);
    run_.paused = paused;
  }
  changed_.notify_all();
}

std::optional<RemotePicture> RemoteTraining::take_picture() {
  const std::lock_guard lock(mutex_);
  return std::exchange(picture_, std::nullopt);
}

RemoteRun RemoteTraining::run() {
  const std::lock_guard lock(mutex_);
  return run_;
}

template <class Change>
void RemoteTraining::change(Change&& change) {
  {
    const std::lock_guard lock(mutex_);
    change();
  }
  wake_();
}

bool RemoteTraining::is_due() const {
  return view_->is_moving || view_->version != asked_version_ || run_.paused != asked_paused_ ||
         Clock::now() >= next_visit_;
}

void RemoteTraining::loop(const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    {
      std::unique_lock lock(mutex_);
      changed_.wait(lock, stop, [&] { return view_.has_value(); });
      // After a failure nothing is due before the next visit.
      const bool failed = !run_.problem.empty() && !socket_.is_open();
      changed_.wait_until(lock, stop, next_visit_, [&] { return !failed && is_due(); });
      if (stop.stop_requested()) return;
    }
    try {
      visit(stop);
    } catch (const std::bad_alloc&) {
      close_with(fmt::format("{}: there is not enough memory for a picture", address_.text));
    }
  }
}

// One request. The connection stays while more requests follow soon.
void RemoteTraining::visit(const std::stop_token& stop) {
  if (!socket_.is_open() && !open(stop)) return;
  if (!ask(stop)) return;
  const std::lock_guard lock(mutex_);
  const bool goes_on =
      view_->is_moving || view_->version != asked_version_ || run_.paused != asked_paused_;
  next_visit_ = Clock::now() + (asked_paused_ ? times_.pause_turn : times_.visit);
  if (!goes_on && !asked_paused_) socket_.close();
}

bool RemoteTraining::open(const std::stop_token& stop) {
  has_answered_ = false;
  int problem = 0;
  socket_ = connect(address_, patience(times_.connecting, stop), problem);
  if (stop.stop_requested()) return false;
  if (!socket_.is_open()) {
    close_with(fmt::format("{}: the training does not answer: {}", address_.text,
                           problem == 0 ? "no connection" : std::strerror(problem)));
    return false;
  }
  if (dialect_ == Dialect::trainer_first) return read_modes(stop);
  if (dialect_ == Dialect::viewer_first) return true;
  if (socket_.await_bytes(patience(times_.first_word, stop)) != TcpEnd::done) return true;
  return read_modes(stop);
}

bool RemoteTraining::ask(const std::stop_token& stop) {
  RemoteView view;
  SibrRequest request;
  {
    const std::lock_guard lock(mutex_);
    view = *view_;
    request = request_for(view.camera);
    request.splat_scale = view.splat_scale;
    request.trains = !run_.paused;
    asked_version_ = view.version;
    asked_paused_ = run_.paused;
  }
  const auto began = Clock::now();
  const std::string message = sibr_message(request);
  if (socket_.write(std::as_bytes(std::span(message)), patience(times_.silence, stop)) !=
      TcpEnd::done) {
    if (!stop.stop_requested())
      close_with(fmt::format("{}: the training has closed the connection", address_.text));
    return false;
  }
  std::vector<std::byte> rgb(3 * static_cast<std::size_t>(request.width) *
                             static_cast<std::size_t>(request.height));
  std::string source, metrics;
  if (!read_picture(rgb, stop) || !read_text(source, stop)) return false;
  if (dialect_ == Dialect::trainer_first && !read_text(metrics, stop)) return false;
  if (dialect_ == Dialect::unknown) dialect_ = Dialect::viewer_first;
  has_answered_ = true;
  RemotePicture picture{view.camera, view.version, request.width, request.height, rgba_of(rgb), 0};
  picture.ms = std::chrono::duration<double, std::milli>(Clock::now() - began).count();
  change([&] {
    picture_ = std::move(picture);
    run_.is_answering = true;
    run_.problem.clear();
    run_.speaks_first = dialect_ == Dialect::trainer_first;
    run_.source = source;
    if (!metrics.empty()) run_.metrics = parse_metrics(metrics);
    ++run_.pictures;
  });
  return true;
}

bool RemoteTraining::read(std::span<std::byte> bytes, const std::stop_token& stop) {
  // The request is under way, so the training does not wait for this viewer. A peer that is
  // occupied answers later: the connection stays in its backlog.
  TcpEnd end = socket_.await_bytes(patience(times_.silence, stop));
  if (end == TcpEnd::late) {
    change([&] {
      run_.is_answering = false;
      run_.problem = fmt::format(
          "{}: no answer: another viewer is connected, or the training is busy", address_.text);
    });
    while (end == TcpEnd::late) end = socket_.await_bytes(patience(times_.silence, stop));
  }
  if (end == TcpEnd::done) end = socket_.read(bytes, patience(times_.silence, stop));
  if (end == TcpEnd::done) return true;
  if (end == TcpEnd::stopped) return false;
  close_with(
      end == TcpEnd::late
          ? fmt::format("{}: the training has stopped in the middle of an answer", address_.text)
          : fmt::format("{}: the training has closed the connection", address_.text));
  return false;
}

bool RemoteTraining::read_text(std::string& text, const std::stop_token& stop) {
  std::array<std::byte, kLengthBytes> length{};
  if (!read(length, stop)) return false;
  const std::size_t size = length_of(length);
  if (size > kMostText) {
    close_with(fmt::format(kOtherProtocol, address_.text));
    return false;
  }
  text.resize(size);
  return size == 0 || read(std::as_writable_bytes(std::span(text)), stop);
}

bool RemoteTraining::read_modes(const std::stop_token& stop) {
  std::string text;
  if (!read_text(text, stop)) return false;
  if (!parse_render_modes(text)) {
    close_with(fmt::format(kOtherProtocol, address_.text));
    return false;
  }
  dialect_ = Dialect::trainer_first;
  return true;
}

// A trainer whose iterations are long may speak first after the request: then its list is in front
// of the first picture.
bool RemoteTraining::read_picture(std::vector<std::byte>& rgb, const std::stop_token& stop) {
  const bool may_be_list =
      dialect_ != Dialect::trainer_first && !has_answered_ && rgb.size() >= kLengthBytes;
  if (!may_be_list) return read(rgb, stop);
  const std::span whole(rgb);
  if (!read(whole.first(kLengthBytes), stop)) return false;
  const std::size_t size = length_of(whole.first<kLengthBytes>());
  std::size_t known = kLengthBytes;
  if (size > 1 && size <= std::min(kMostText, rgb.size() - kLengthBytes)) {
    if (!read(whole.subspan(kLengthBytes, size), stop)) return false;
    const std::string text(reinterpret_cast<const char*>(rgb.data()) + kLengthBytes, size);
    known += size;
    if (parse_render_modes(text)) {
      dialect_ = Dialect::trainer_first;
      known = 0;
    }
  }
  return known == rgb.size() || read(whole.subspan(known), stop);
}

void RemoteTraining::close_with(const std::string& problem) {
  socket_.close();
  dialect_ = Dialect::unknown;
  change([&] {
    run_.is_answering = false;
    run_.problem = problem;
    next_visit_ = Clock::now() + times_.visit;
  });
}

}  // namespace qs
