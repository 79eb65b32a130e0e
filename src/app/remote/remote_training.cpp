// SPDX-License-Identifier: MIT
#include "app/remote/remote_training.h"

#include <algorithm>
#include <cstring>
#include <new>
#include <utility>

#include <fmt/format.h>

#include "base/seconds.h"

namespace qs {
namespace {

std::vector<std::uint8_t> rgba_of(std::span<const std::byte> rgb) {
  std::vector<std::uint8_t> rgba(rgb.size() / 3 * 4, 255);
  for (std::size_t i = 0; i < rgb.size() / 3; ++i)
    for (std::size_t c = 0; c < 3; ++c)
      rgba[4 * i + c] = std::to_integer<std::uint8_t>(rgb[3 * i + c]);
  return rgba;
}

}  // namespace

RemoteTraining::RemoteTraining(TcpAddress address, std::function<void()> wake,
                               const RemoteTimes& times)
    : address_(std::move(address)), wake_(std::move(wake)), times_(times) {
  run_.address = address_.text;
  thread_ = std::jthread([this](const std::stop_token& stop) { loop(stop); });
}

void RemoteTraining::show(const RemoteView& view) {
  const std::lock_guard lock(mutex_);
  view_ = view;
  changed_.notify_all();
}

void RemoteTraining::pause(bool paused) {
  const std::lock_guard lock(mutex_);
  run_.paused = paused;
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
      close_with("there is not enough memory for a picture");
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
    close_with(fmt::format("the training does not answer: {}",
                           problem == 0 ? "no connection" : std::strerror(problem)));
    return false;
  }
  const bool speaks_first =
      dialect_ == SibrDialect::trainer_first ||
      (dialect_ == SibrDialect::unknown &&
       socket_.await_bytes(patience(times_.first_word, stop)) == TcpEnd::done);
  return !speaks_first || is_sound(read_sibr_modes(reader(stop), dialect_));
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
    if (!stop.stop_requested()) close_with("the training has closed the connection");
    return false;
  }
  SibrAnswer answer;
  const std::size_t rgb_bytes =
      3 * static_cast<std::size_t>(request.width) * static_cast<std::size_t>(request.height);
  if (!is_sound(read_sibr_answer(reader(stop), rgb_bytes, !has_answered_, dialect_, answer)))
    return false;
  has_answered_ = true;
  RemotePicture picture{view.camera,    view.version,        request.width,
                        request.height, rgba_of(answer.rgb), 0};
  picture.ms = milliseconds_since(began);
  change([&] {
    picture_ = std::move(picture);
    run_.is_answering = true;
    run_.problem.clear();
    run_.speaks_first = dialect_ == SibrDialect::trainer_first;
    run_.source = answer.source;
    if (!answer.metrics.empty()) run_.metrics = parse_metrics(answer.metrics);
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
  close_with(end == TcpEnd::late ? "the training has stopped in the middle of an answer"
                                 : "the training has closed the connection");
  return false;
}

ReadBytes RemoteTraining::reader(const std::stop_token& stop) {
  return [this, &stop](std::span<std::byte> bytes) { return read(bytes, stop); };
}

bool RemoteTraining::is_sound(SibrEnd end) {
  if (end == SibrEnd::foreign)
    close_with("the answer is not a training's: does another program listen there?");
  return end == SibrEnd::done;
}

void RemoteTraining::close_with(const std::string& problem) {
  socket_.close();
  dialect_ = SibrDialect::unknown;
  change([&] {
    run_.is_answering = false;
    run_.problem = fmt::format("{}: {}", address_.text, problem);
    next_visit_ = Clock::now() + times_.visit;
  });
}

}  // namespace qs
