// SPDX-License-Identifier: MIT
#include "app/film/film_file.h"

#include <system_error>

#include <unistd.h>

#include "app/film/ffmpeg.h"
#include "app/film/film_format.h"
#include "io/bytes/replace_file.h"
#include "io/picture/image_file.h"
#include "raster/base/fail.h"

namespace qs {
namespace {

namespace fs = std::filesystem;

fs::path picture_name(int number) { return fmt::format("frame_{:05}.png", number); }

// A hidden folder beside its final path.
struct HiddenFolder {
  fs::path path;
  explicit HiddenFolder(const fs::path& target)
      : path(target.parent_path() /
             fmt::format(".{}.{}.tmp", target.filename().string(), getpid())) {
    std::error_code error;
    fs::create_directories(path, error);
    if (error) fail("{}: cannot be made: {}", target.string(), error.message());
  }
  ~HiddenFolder() {
    std::error_code ignored;
    fs::remove_all(path, ignored);
  }
  HiddenFolder(const HiddenFolder&) = delete;
  HiddenFolder& operator=(const HiddenFolder&) = delete;
};

void write_folder(const fs::path& path, const std::function<void(const AddPicture& add)>& draw) {
  const HiddenFolder hidden(path);
  int count = 0;
  draw([&](const Image& picture) { write_image(picture, hidden.path / picture_name(count++)); });
  std::error_code error;
  fs::create_directories(path, error);
  for (int i = 0; i < count && !error; ++i)
    fs::rename(hidden.path / picture_name(i), path / picture_name(i), error);
  if (error) fail("{}: cannot be written: {}", path.string(), error.message());
  for (int i = count; fs::remove(path / picture_name(i), error); ++i) {
  }
}

}  // namespace

void write_film_file(const fs::path& path, glm::ivec2 size, double fps,
                     const std::function<void(const AddPicture& add)>& draw) {
  const FilmFormat& format = film_format(path, size, fps);
  if (format.folder()) return write_folder(path, draw);
  replace_file(path, [&](const fs::path& temporary) {
    Ffmpeg ffmpeg(temporary, path.string(), size, fps, format.options);
    draw([&](const Image& picture) { ffmpeg.add(picture); });
    ffmpeg.finish();
  });
}

}  // namespace qs
