// SPDX-License-Identifier: MIT
#include "app/support/terminal.h"

#include <cstdio>

#include <fcntl.h>
#include <gtest/gtest.h>
#include <pty.h>
#include <unistd.h>

namespace qs::test {

Terminal::Terminal() : kept_(dup(STDERR_FILENO)) {
  int screen = -1;
  EXPECT_EQ(openpty(&keyboard_, &screen, nullptr, nullptr, nullptr), 0);
  dup2(screen, STDERR_FILENO);
  close(screen);
  fcntl(keyboard_, F_SETFL, O_NONBLOCK);
}

Terminal::~Terminal() {
  std::fflush(stderr);
  dup2(kept_, STDERR_FILENO);
  close(kept_);
  close(keyboard_);
}

std::string Terminal::shown() const {
  std::string text(4096, '\0');
  const ssize_t count = read(keyboard_, text.data(), text.size());
  text.resize(count > 0 ? static_cast<std::size_t>(count) : 0);
  return text;
}

}  // namespace qs::test
