// SPDX-License-Identifier: MIT
#include "base/progress_bar.h"

#include <algorithm>
#include <cstdio>
#include <utility>

#include <fmt/format.h>
#include <unistd.h>

namespace qs {

std::string progress_line(const std::string& label, float fraction, double seconds) {
  constexpr std::size_t kWidth = 32;
  const float done = std::clamp(fraction, 0.0f, 1.0f);
  const auto filled = static_cast<std::size_t>(done * kWidth);
  std::string line = fmt::format("{} [{}{}] {:3} %", label, std::string(filled, '#'),
                                 std::string(kWidth - filled, ' '), static_cast<int>(done * 100));
  if (done <= 0) return line;
  const double share = static_cast<double>(done);
  const auto left = static_cast<long>(seconds * (1 - share) / share + 0.5);
  return left < 3600
             ? fmt::format("{}, {}:{:02} left", line, left / 60, left % 60)
             : fmt::format("{}, {}:{:02}:{:02} left", line, left / 3600, left / 60 % 60, left % 60);
}

Progress part_of(const Progress& progress, float begin, float end) {
  if (!progress.report) return progress;
  return {
      [=, report = progress.report](float fraction) { report(begin + (end - begin) * fraction); },
      progress.stop};
}

Progress step_of(const Progress& progress, std::size_t step, std::size_t steps) {
  const auto share = [&](std::size_t i) {
    return static_cast<float>(i) / static_cast<float>(steps);
  };
  return part_of(progress, share(step), share(step + 1));
}

std::function<ProgressBar::Clock::time_point()>& ProgressBar::usual_clock() {
  static std::function<Clock::time_point()> clock = Clock::now;
  return clock;
}

ProgressBar::ProgressBar(std::string label, std::function<Clock::time_point()> now)
    : label_(std::move(label)),
      now_(std::move(now)),
      start_(now_()),
      terminal_(isatty(STDERR_FILENO) != 0) {}

ProgressBar::~ProgressBar() { hide(); }

void ProgressBar::relabel(std::string label) { label_ = std::move(label); }

void ProgressBar::hide() {
  if (shown_percent_ < 0) return;
  shown_percent_ = -1;
  fmt::print(stderr, "\r\033[K");
  std::fflush(stderr);
}

Progress ProgressBar::progress() {
  if (!terminal_) return {};
  return {[this](float fraction) { show(fraction); }, {}};
}

void ProgressBar::show(float fraction) {
  constexpr auto kPatience = std::chrono::milliseconds(300);
  constexpr auto kInterval = std::chrono::milliseconds(500);  // time between new labels and times
  const int percent = static_cast<int>(std::clamp(fraction, 0.0f, 1.0f) * 100);
  const auto now = now_();
  if (now - start_ < kPatience) return;
  const bool first_step = fraction > 0 && !shows_time_left_;
  if (percent == shown_percent_ && !first_step && now - shown_at_ < kInterval) return;
  shown_percent_ = percent;
  shows_time_left_ = fraction > 0;
  shown_at_ = now;
  const double seconds = std::chrono::duration<double>(now - start_).count();
  fmt::print(stderr, "\r{}\033[K", progress_line(label_, fraction, seconds));
  std::fflush(stderr);
}

}  // namespace qs
