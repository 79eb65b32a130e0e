// SPDX-License-Identifier: MIT
#include "app/film/ffmpeg.h"

#include <span>

#include <sys/socket.h>
#include <unistd.h>

#include "base/fail.h"
#include "base/text.h"

namespace qs {
namespace {

std::vector<std::string> command_line(const std::filesystem::path& output, glm::ivec2 size,
                                      double fps, const std::vector<std::string>& options) {
  std::vector<std::string> words =
      separated(fmt::format("ffmpeg -hide_banner -nostdin -loglevel error -xerror -y -f rawvideo "
                            "-pix_fmt rgb24 -video_size {}x{} -framerate {} -i pipe:0",
                            size.x, size.y, fps),
                ' ');
  words.insert(words.end(), options.begin(), options.end());
  words.push_back("file:" + output.string());  // "file:" in case the name looks like a protocol
  return words;
}

}  // namespace

// A group of its own, so that Ctrl+C does not reach ffmpeg and this program alone decides if the
// film is completed.
Ffmpeg::Ffmpeg(const std::filesystem::path& output, std::string name, glm::ivec2 size, double fps,
               const std::vector<std::string>& options)
    : name_(std::move(name)),
      process_({.words = command_line(output, size, fps, options),
                .own_group = true,
                .keeps_messages = true,
                .socket = {{SOCK_STREAM, STDIN_FILENO}}}) {}

void Ffmpeg::add(const Image& picture) {
  bytes_.resize(picture.values.size());
  for (std::size_t i = 0; i < bytes_.size(); ++i) bytes_[i] = to_8bit(picture.values[i]);
  if (process_.send(std::as_bytes(std::span(bytes_)))) return;
  process_.wait();
  fail("{}: ffmpeg ended before the film did: {}", name_, first_message());
}

void Ffmpeg::finish() {
  process_.close_socket();
  if (!process_.wait().good()) fail("{}: ffmpeg failed: {}", name_, first_message());
}

// The first line of ffmpeg's messages; later lines follow from the first error.
std::string Ffmpeg::first_message() const {
  for (const std::string& line : separated(process_.messages(1000), '\n'))
    if (!line.empty()) return line;
  return "it gives no reason";
}

}  // namespace qs
