// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cstdlib>
#include <span>
#include <system_error>

#include <sys/socket.h>
#include <unistd.h>

#include "app/film/film.h"
#include "base/child_process.h"
#include "base/fail.h"
#include "base/text.h"
#include "io/bytes/file_guard.h"
#include "io/bytes/replace_file.h"
#include "io/picture/image_file.h"

namespace qs {
namespace {

namespace fs = std::filesystem;

struct FilmFormat {
  std::string ending;  // with its dot; empty: a folder of PNG files, without ffmpeg
  std::vector<std::string> options = {};  // ffmpeg's options for the file
  bool even_size = false;                 // width and height must be even
  double most_fps = 240;                  // pictures per second

  bool folder() const { return ending.empty(); }
};

// Films are sRGB, and players expect the colour matrix of HD television.
std::vector<std::string> video(const std::string& codec) {
  return separated(
      "-vf scale=out_color_matrix=bt709:out_range=tv,format=yuv420p -colorspace bt709 "
      "-color_range tv -color_primaries bt709 -color_trc iec61966-2-1 " +
          codec,
      ' ');
}

const FilmFormat kFormats[] = {
    {".mp4", video("-c:v libx264 -crf 18 -movflags +faststart"), true},
    {".webm", video("-c:v libvpx-vp9 -crf 24 -b:v 0 -row-mt 1")},
    // A palette per picture, because a palette for the whole film would need all pictures in
    // memory.
    {".gif",
     {"-vf",
      "split[a][b];[a]palettegen=stats_mode=single[p];[b][p]paletteuse=new=1:dither=sierra2_4a"},
     false,
     50},  // times are counted in hundredths of a second
    {""},
};

// The format of a film that may be written, see check_film().
const FilmFormat& checked_format(const fs::path& path, glm::ivec2 size, double fps) {
  const std::string ending = picture_extension(path);
  const auto found = std::ranges::find(kFormats, ending, &FilmFormat::ending);
  if (found == std::end(kFormats)) {
    fail(
        ErrorKind::usage,
        "{}: a film ends in .mp4, .webm or .gif; a name without an ending is a folder of PNG files",
        path.string());
  }
  if (found->even_size && (size.x % 2 != 0 || size.y % 2 != 0)) {
    fail(ErrorKind::usage, "{}: {} needs an even width and height, but the size is {} x {}",
         path.string(), ending, size.x, size.y);
  }
  if (fps > found->most_fps) {
    fail(ErrorKind::usage, "{}: {} holds at most {} pictures per second", path.string(), ending,
         found->most_fps);
  }
  if (!found->folder() && !ffmpeg_is_installed()) {
    fail(ErrorKind::device,
         "{}: ffmpeg encodes films and is not installed; a name without an ending, such as {}, is "
         "a folder of PNG files and does not need it",
         path.string(), path.stem().string());
  }
  if (found->folder()) {
    check_folder(path);
    require_new_folder(path, may_overwrite());
  } else {
    check_targets({path});
  }
  return *found;
}

// An ffmpeg process that encodes pictures, which it reads from this program.
class Ffmpeg {
 public:
  /// Starts the process, which writes `output`; messages call it `name`. Throws Error(device) if it
  /// cannot be started. The process is killed unless finish() is called. It has a group of its own,
  /// so that Ctrl+C does not reach ffmpeg and this program alone decides if the film is completed.
  Ffmpeg(const fs::path& output, std::string name, glm::ivec2 size, double fps,
         const std::vector<std::string>& options)
      : name_(std::move(name)),
        process_({.words = command_line(output, size, fps, options),
                  .own_group = true,
                  .keeps_messages = true,
                  .socket = {{SOCK_STREAM, STDIN_FILENO}}}) {}

  /// Sends an RGB picture of the film's size to ffmpeg. Throws Error(input) with ffmpeg's message
  /// if it has ended.
  void add(const Image& picture) {
    bytes_.resize(picture.values.size());
    std::transform(picture.values.begin(), picture.values.end(), bytes_.begin(), to_8bit);
    if (process_.send(std::as_bytes(std::span(bytes_)))) return;
    process_.wait();
    fail("{}: ffmpeg ended before the film did: {}", name_, first_message());
  }

  /// Waits until the file is complete. Throws as add().
  void finish() {
    process_.close_socket();
    if (!process_.wait().good()) fail("{}: ffmpeg failed: {}", name_, first_message());
  }

 private:
  static std::vector<std::string> command_line(const fs::path& output, glm::ivec2 size, double fps,
                                               const std::vector<std::string>& options) {
    std::vector<std::string> words =
        separated(fmt::format("ffmpeg -hide_banner -nostdin -loglevel error -xerror -y -f rawvideo "
                              "-pix_fmt rgb24 -video_size {}x{} -framerate {} -i pipe:0",
                              size.x, size.y, fps),
                  ' ');
    words.insert(words.end(), options.begin(), options.end());
    words.push_back("file:" + output.string());  // "file:" in case the name looks like a protocol
    return words;
  }

  // The first line of ffmpeg's messages; later lines follow from the first error.
  std::string first_message() const {
    for (const std::string& line : separated(process_.messages(1000), '\n'))
      if (!line.empty()) return line;
    return "it gives no reason";
  }

  std::string name_;
  ChildProcess process_;
  std::vector<std::uint8_t> bytes_;
};

fs::path picture_name(int number) { return fmt::format("frame_{:05}.png", number); }

void write_folder(const fs::path& path, const std::function<void(const AddPicture& add)>& draw) {
  int count = 0;
  replace_folder(path, [&](const fs::path& hidden) {
    draw([&](const Image& picture) { write_image(picture, hidden / picture_name(count++)); });
  });
  std::error_code ignored;
  while (is_own_report(path / picture_name(count)))
    fs::remove(path / picture_name(count++), ignored);
}

}  // namespace

bool ffmpeg_is_installed() {
  const char* folders = std::getenv("PATH");
  for (const std::string& folder : separated(folders == nullptr ? "" : folders, ':')) {
    if (!folder.empty() && access((folder + "/ffmpeg").c_str(), X_OK) == 0) return true;
  }
  return false;
}

void check_film(const fs::path& path, glm::ivec2 size, double fps) {
  checked_format(path, size, fps);
}

void write_film_file(const fs::path& path, glm::ivec2 size, double fps,
                     const std::function<void(const AddPicture& add)>& draw) {
  const FilmFormat& format = checked_format(path, size, fps);
  if (format.folder()) return write_folder(path, draw);
  replace_file(path, [&](const fs::path& temporary) {
    Ffmpeg ffmpeg(temporary, path.string(), size, fps, format.options);
    draw([&](const Image& picture) { ffmpeg.add(picture); });
    ffmpeg.finish();
  });
}

}  // namespace qs
