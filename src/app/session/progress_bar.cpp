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

ProgressBar::~ProgressBar() {
  if (shown_percent_ >= 0) fmt::print(stderr, "\r\033[K");
}

Progress ProgressBar::progress() {
  if (!terminal_) return {};
  return {[this](float fraction) { show(fraction); }, {}};
}

void ProgressBar::show(float fraction) {
  constexpr auto kPatience = std::chrono::milliseconds(300);
  constexpr std::size_t kWidth = 32;
  const float clamped = std::clamp(fraction, 0.0f, 1.0f);
  const int percent = static_cast<int>(clamped * 100);
  if (percent == shown_percent_ || std::chrono::steady_clock::now() - start_ < kPatience) return;
  shown_percent_ = percent;
  const auto filled = static_cast<std::size_t>(clamped * kWidth);
  const double elapsed =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  const auto left = static_cast<long>(percent > 0 ? elapsed * (100 - percent) / percent + 0.5 : 0);
  fmt::print(stderr, "\r{} [{}{}] {:3} %{}\033[K", label_, std::string(filled, '#'),
             std::string(kWidth - filled, ' '), percent,
             percent > 0 ? fmt::format(", {}:{:02} left", left / 60, left % 60) : "");
  std::fflush(stderr);
}

}  // namespace qs
