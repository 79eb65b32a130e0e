// SPDX-License-Identifier: MIT
#include "app/session/progress_bar.h"

#include <algorithm>
#include <cstdio>
#include <utility>

#include <fmt/format.h>
#include <unistd.h>

namespace qs {

ProgressBar::ProgressBar(std::string label)
    : label_(std::move(label)),
      start_(std::chrono::steady_clock::now()),
      terminal_(isatty(STDERR_FILENO) != 0) {}

ProgressBar::~ProgressBar() { hide(); }

void ProgressBar::relabel(std::string label) {
  new_label_ = new_label_ || label != label_;
  label_ = std::move(label);
}

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
  constexpr auto kLabelInterval = std::chrono::milliseconds(500);
  constexpr std::size_t kWidth = 32;
  const float clamped = std::clamp(fraction, 0.0f, 1.0f);
  const int percent = static_cast<int>(clamped * 100);
  const auto now = std::chrono::steady_clock::now();
  const bool relabelled = new_label_ && now - shown_at_ >= kLabelInterval;
  if ((percent == shown_percent_ && !relabelled) || now - start_ < kPatience) return;
  shown_percent_ = percent;
  shown_at_ = now;
  new_label_ = false;
  const auto filled = static_cast<std::size_t>(clamped * kWidth);
  const double elapsed = std::chrono::duration<double>(now - start_).count();
  const auto left = static_cast<long>(percent > 0 ? elapsed * (100 - percent) / percent + 0.5 : 0);
  fmt::print(stderr, "\r{} [{}{}] {:3} %{}\033[K", label_, std::string(filled, '#'),
             std::string(kWidth - filled, ' '), percent,
             percent > 0 ? fmt::format(", {}:{:02} left", left / 60, left % 60) : "");
  std::fflush(stderr);
}

}  // namespace qs
