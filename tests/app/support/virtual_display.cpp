// SPDX-License-Identifier: MIT
#include "app/support/virtual_display.h"

#include <array>
#include <csignal>
#include <cstdlib>

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

namespace qs::test {

VirtualDisplay::VirtualDisplay(const std::string& size) {
  std::array<int, 2> ends{};
  if (pipe(ends.data()) != 0) return;
  server_ = fork();
  if (server_ == 0) {
    const int nowhere = open("/dev/null", O_WRONLY);
    dup2(nowhere, STDOUT_FILENO);  // CTest waits until no process holds a test's output open
    dup2(nowhere, STDERR_FILENO);
    prctl(PR_SET_PDEATHSIG, SIGTERM);  // ends with the test, also if that aborts
    dup2(ends[1], 3);                  // where the server writes its number once it is ready
    execlp("Xvfb", "Xvfb", "-displayfd", "3", "-screen", "0", size.c_str(), "-nolisten", "tcp",
           static_cast<char*>(nullptr));
    _exit(127);
  }
  close(ends[1]);
  std::string number;
  pollfd ready{ends[0], POLLIN, 0};
  constexpr int kStartMs = 30'000;
  char c = 0;
  while (poll(&ready, 1, kStartMs) > 0 && read(ends[0], &c, 1) == 1 && c != '\n') number += c;
  close(ends[0]);
  if (number.empty()) return;
  setenv("DISPLAY", (":" + number).c_str(), 1);
  unsetenv("WAYLAND_DISPLAY");
  runs_ = true;
}

VirtualDisplay::~VirtualDisplay() {
  unsetenv("DISPLAY");
  if (server_ <= 0) return;
  kill(server_, SIGTERM);
  waitpid(server_, nullptr, 0);
}

}  // namespace qs::test
