// SPDX-License-Identifier: MIT
#include "app/film/ffmpeg.h"

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstring>

#include <fcntl.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include "app/base/text.h"
#include "raster/base/fail.h"

namespace qs {
namespace {

std::vector<std::string> command_line(const std::filesystem::path& output, glm::ivec2 size,
                                      double fps, const std::vector<std::string>& options) {
  std::vector<std::string> words = {"ffmpeg",
                                    "-hide_banner",
                                    "-nostdin",
                                    "-loglevel",
                                    "error",
                                    "-xerror",
                                    "-y",
                                    "-f",
                                    "rawvideo",
                                    "-pix_fmt",
                                    "rgb24",
                                    "-video_size",
                                    fmt::format("{}x{}", size.x, size.y),
                                    "-framerate",
                                    fmt::format("{}", fps),
                                    "-i",
                                    "pipe:0"};
  words.insert(words.end(), options.begin(), options.end());
  words.push_back("file:" + output.string());  // "file:" in case the name looks like a protocol
  return words;
}

// A group of its own keeps Ctrl+C from the process, so that only this program decides if the film
// is completed. posix_spawnp() and not fork(): this process has threads, and perhaps a CUDA
// context.
pid_t start(std::vector<std::string> words, int input, int messages) {
  posix_spawn_file_actions_t actions;
  posix_spawnattr_t attributes;
  posix_spawn_file_actions_init(&actions);
  posix_spawnattr_init(&attributes);
  posix_spawn_file_actions_adddup2(&actions, input, STDIN_FILENO);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
  posix_spawn_file_actions_adddup2(&actions, messages, STDERR_FILENO);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  pid_t child = 0;
  const int error =
      posix_spawnp(&child, arguments[0], &actions, &attributes, arguments.data(), environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&actions);
  if (error != 0) fail(ErrorKind::device, "ffmpeg does not start: {}", std::strerror(error));
  return child;
}

}  // namespace

Ffmpeg::Ffmpeg(const std::filesystem::path& output, std::string name, glm::ivec2 size, double fps,
               const std::vector<std::string>& options)
    : name_(std::move(name)), messages_(memfd_create("ffmpeg's messages", MFD_CLOEXEC)) {
  // A socket and not a pipe: send() can be told not to raise SIGPIPE.
  int ends[2] = {-1, -1};
  if (messages_ < 0 || socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0)
    fail(ErrorKind::device, "ffmpeg does not start: {}", std::strerror(errno));
  pipe_ = ends[0];
  try {
    process_ = start(command_line(output, size, fps, options), ends[1], messages_);
  } catch (...) {
    close(ends[1]);
    close_pipe();
    close(messages_);
    throw;
  }
  close(ends[1]);
}

Ffmpeg::~Ffmpeg() {
  if (process_ > 0) {
    kill(process_, SIGKILL);
    wait();
  }
  close_pipe();
  close(messages_);
}

void Ffmpeg::add(const Image& picture) {
  bytes_.resize(picture.values.size());
  for (std::size_t i = 0; i < bytes_.size(); ++i) bytes_[i] = to_8bit(picture.values[i]);
  for (std::size_t sent = 0; sent < bytes_.size();) {
    const ssize_t count = send(pipe_, bytes_.data() + sent, bytes_.size() - sent, MSG_NOSIGNAL);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) {
      wait();
      fail("{}: ffmpeg ended before the film did: {}", name_, first_message());
    }
    sent += static_cast<std::size_t>(count);
  }
}

void Ffmpeg::finish() {
  close_pipe();
  const int status = wait();
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0)
    fail("{}: ffmpeg failed: {}", name_, first_message());
}

int Ffmpeg::wait() {
  int status = 0;
  while (waitpid(process_, &status, 0) < 0 && errno == EINTR) {
  }
  process_ = 0;
  return status;
}

void Ffmpeg::close_pipe() {
  if (pipe_ >= 0) close(pipe_);
  pipe_ = -1;
}

// The first line of ffmpeg's messages; later lines follow from the first error.
std::string Ffmpeg::first_message() const {
  std::string text(1000, '\0');
  const ssize_t count = pread(messages_, text.data(), text.size(), 0);
  text.resize(static_cast<std::size_t>(std::max<ssize_t>(count, 0)));
  for (const std::string& line : separated(text, '\n'))
    if (!line.empty()) return line;
  return "it gives no reason";
}

}  // namespace qs
