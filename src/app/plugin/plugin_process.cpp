// SPDX-License-Identifier: MIT
#include "app/plugin/plugin_process.h"

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <thread>

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include "io/bytes/program_folder.h"
#include "raster/base/fail.h"

namespace qs {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds kPollPeriod{100};  // in which a cancellation is noticed
constexpr std::chrono::seconds kTimeToEnd{5};          // of a process that closed its socket

const char* activity(PluginCall call) {
  switch (call) {
    case PluginCall::open:
      return "while opening the scene";
    case PluginCall::render:
      return "while rendering";
    case PluginCall::close:
      return "while closing the scene";
  }
  return "";
}

// posix_spawn() and not fork(): this process has threads, and perhaps a CUDA context.
pid_t start(const std::filesystem::path& library, int socket, int scene, int image) {
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  // stdout is for reports, so the output of a plugin goes to stderr.
  posix_spawn_file_actions_adddup2(&actions, STDERR_FILENO, STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&actions, socket, kPluginSocket);
  posix_spawn_file_actions_adddup2(&actions, scene, kPluginScene);
  posix_spawn_file_actions_adddup2(&actions, image, kPluginImage);
  std::string program = (program_folder() / "quadsplat").string();
  std::string command = kPluginHostCommand, file = std::filesystem::absolute(library).string();
  char* const arguments[] = {program.data(), command.data(), file.data(), nullptr};
  pid_t child = 0;
  const int error = posix_spawn(&child, program.c_str(), &actions, nullptr, arguments, environ);
  posix_spawn_file_actions_destroy(&actions);
  if (error != 0) {
    fail(ErrorKind::device, "cannot be run, because {} does not start: {}", program,
         std::strerror(error));
  }
  return child;
}

}  // namespace

PluginProcess::PluginProcess(const std::filesystem::path& library, int scene, int image) {
  int ends[2] = {-1, -1};
  if (socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends) != 0)
    fail(ErrorKind::device, "cannot be run: socketpair: {}", std::strerror(errno));
  Descriptor ours(ends[0]);
  const Descriptor theirs = kept(ends[1], "socketpair");
  process_ = start(library, theirs.get(), scene, image);
  socket_ = std::move(ours);
}

PluginProcess::~PluginProcess() {
  if (running()) kill_and_wait();
}

PluginReply PluginProcess::request(const PluginRequest& request, int timeout_s,
                                   const std::stop_token& stop) {
  const auto deadline = Clock::now() + std::chrono::seconds(timeout_s);
  if (send(socket_.get(), &request, sizeof request, MSG_NOSIGNAL) != sizeof request)
    report_end(request.call);
  for (;;) {
    pollfd descriptor = {socket_.get(), POLLIN, 0};
    const int ready = poll(&descriptor, 1, static_cast<int>(kPollPeriod.count()));
    if (stop.stop_requested()) {
      kill_and_wait();
      throw Cancelled();
    }
    if (ready > 0) break;
    if (Clock::now() < deadline) continue;
    kill_and_wait();
    timed_out_ = true;
    fail(ErrorKind::device, "did not answer within {} s {}, so its process was ended", timeout_s,
         activity(request.call));
  }
  PluginReply reply;
  if (recv(socket_.get(), &reply, sizeof reply, 0) != sizeof reply) report_end(request.call);
  reply.message.back() = reply.name.back() = reply.description.back() = '\0';
  return reply;
}

void PluginProcess::kill_and_wait() {
  kill(process_, SIGKILL);
  while (waitpid(process_, nullptr, 0) < 0 && errno == EINTR) {
  }
  process_ = 0;
}

// The process closed its socket, usually because it ended.
void PluginProcess::report_end(PluginCall call) {
  int status = 0;
  const auto deadline = Clock::now() + kTimeToEnd;
  while (waitpid(process_, &status, WNOHANG) == 0) {
    if (Clock::now() > deadline) {
      kill_and_wait();
      fail(ErrorKind::device, "closed quadsplat's socket {}", activity(call));
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  process_ = 0;
  if (WIFSIGNALED(status)) {
    fail(ErrorKind::device, "crashed with signal {} ({}) {}", WTERMSIG(status),
         strsignal(WTERMSIG(status)), activity(call));
  }
  fail(ErrorKind::device, "ended its process with exit code {} {}", WEXITSTATUS(status),
       activity(call));
}

}  // namespace qs
