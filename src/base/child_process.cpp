// SPDX-License-Identifier: MIT
#include "base/child_process.h"

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <thread>

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include "base/fail.h"
#include "base/not_copied.h"

namespace qs {
namespace {

// The attributes and descriptors with which a process is started.
class SpawnPlan : NotCopied {
 public:
  explicit SpawnPlan(const ChildCommand& command) : command_(command) {
    posix_spawn_file_actions_init(&actions_);
    posix_spawnattr_init(&attributes_);
    if (command.own_group) posix_spawnattr_setflags(&attributes_, POSIX_SPAWN_SETPGROUP);
    if (!command.folder.empty())
      posix_spawn_file_actions_addchdir_np(&actions_, command.folder.c_str());
    for (const int standard : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
      posix_spawn_file_actions_addopen(&actions_, standard, "/dev/null", O_RDWR, 0);
  }
  ~SpawnPlan() {
    posix_spawnattr_destroy(&attributes_);
    posix_spawn_file_actions_destroy(&actions_);
  }

  // The copies have numbers that the child does not use, so none is overwritten before its turn.
  // addclosefrom_np(), because streams of the standard library open files without O_CLOEXEC.
  void inherit(const std::vector<ChildCommand::Inherited>& rows) {
    int highest = STDERR_FILENO;
    for (const auto& row : rows) highest = std::max(highest, row.number_in_child);
    for (const auto& row : rows) {
      copies_.emplace_back(fcntl(row.number, F_DUPFD_CLOEXEC, highest + 1));
      if (!copies_.back()) refuse(errno);
      posix_spawn_file_actions_adddup2(&actions_, copies_.back().get(), row.number_in_child);
    }
    posix_spawn_file_actions_addclosefrom_np(&actions_, highest + 1);
  }

  // posix_spawnp() and not fork(): this process has threads, and perhaps a CUDA context.
  pid_t start() const {
    std::vector<std::string> words = command_.words;
    std::vector<char*> arguments;
    for (std::string& word : words) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    pid_t process = 0;
    const int error =
        posix_spawnp(&process, arguments[0], &actions_, &attributes_, arguments.data(), environ);
    if (error != 0) refuse(error);
    return process;
  }

  [[noreturn]] void refuse(int error) const {
    fail(ErrorKind::device, "{} does not start: {}", command_.words.front(), std::strerror(error));
  }

 private:
  const ChildCommand& command_;
  posix_spawn_file_actions_t actions_;
  posix_spawnattr_t attributes_;
  std::vector<Descriptor> copies_;
};

ChildEnd end_of(int status) {
  if (WIFSIGNALED(status)) return {0, WTERMSIG(status)};
  return {WEXITSTATUS(status), 0};
}

}  // namespace

std::string ChildEnd::text() const {
  return signal != 0 ? fmt::format("signal {} ({})", signal, strsignal(signal))
                     : fmt::format("exit code {}", exit_code);
}

ChildProcess::ChildProcess(const ChildCommand& command) {
  SpawnPlan plan(command);
  std::vector<ChildCommand::Inherited> rows = command.inherits;
  Descriptor end_of_child;
  if (command.socket) {
    // A socket and not a pipe: send() can be told not to raise SIGPIPE.
    int ends[2] = {-1, -1};
    if (socketpair(AF_UNIX, command.socket->type | SOCK_CLOEXEC, 0, ends) != 0) plan.refuse(errno);
    socket_ = Descriptor(ends[0]);
    end_of_child = Descriptor(ends[1]);
    rows.push_back({end_of_child.get(), command.socket->number_in_child});
  }
  if (command.keeps_messages) {
    // A file and not a pipe: the child never waits until somebody reads its messages.
    messages_ = Descriptor(memfd_create("messages of a process", MFD_CLOEXEC));
    if (!messages_) plan.refuse(errno);
    rows.push_back({messages_.get(), STDERR_FILENO});
  }
  plan.inherit(rows);
  process_ = plan.start();
}

ChildProcess::~ChildProcess() { kill(); }

bool ChildProcess::send(std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t count = ::send(socket_.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return false;
    bytes = bytes.subspan(static_cast<std::size_t>(count));
  }
  return true;
}

bool ChildProcess::can_receive(std::chrono::milliseconds limit) const {
  pollfd descriptor = {socket_.get(), POLLIN, 0};
  return poll(&descriptor, 1, static_cast<int>(limit.count())) > 0;
}

bool ChildProcess::receive(std::span<std::byte> message) {
  ssize_t count = -1;
  do {
    count = recv(socket_.get(), message.data(), message.size(), 0);
  } while (count < 0 && errno == EINTR);
  return count == static_cast<ssize_t>(message.size());
}

ChildEnd ChildProcess::wait() {
  int status = 0;
  while (waitpid(process_, &status, 0) < 0 && errno == EINTR) {
  }
  process_ = 0;
  return end_of(status);
}

std::optional<ChildEnd> ChildProcess::wait_for(std::chrono::milliseconds limit) {
  const auto deadline = std::chrono::steady_clock::now() + limit;
  int status = 0;
  while (waitpid(process_, &status, WNOHANG) == 0) {
    if (std::chrono::steady_clock::now() > deadline) return std::nullopt;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  process_ = 0;
  return end_of(status);
}

void ChildProcess::terminate() {
  if (running()) ::kill(process_, SIGTERM);
}

void ChildProcess::kill() {
  if (!running()) return;
  ::kill(process_, SIGKILL);
  wait();
}

std::string ChildProcess::messages(std::size_t most_bytes) const {
  std::string text(most_bytes, '\0');
  std::size_t size = 0;
  while (size < most_bytes) {
    const ssize_t count =
        pread(messages_.get(), text.data() + size, most_bytes - size, static_cast<off_t>(size));
    if (count <= 0) break;
    size += static_cast<std::size_t>(count);
  }
  text.resize(size);
  return text;
}

}  // namespace qs
