// SPDX-License-Identifier: MIT
#include "app/film/film_file.h"

#include <system_error>

#include "app/film/ffmpeg.h"
#include "app/film/film_format.h"
#include "base/fail.h"
#include "io/bytes/file_guard.h"
#include "io/bytes/replace_file.h"
#include "io/picture/image_file.h"

namespace qs {
namespace {

namespace fs = std::filesystem;

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

void check_film_target(const fs::path& path) {
  if (path.has_extension()) return check_targets({path});
  check_folder(path);
  require_new_folder(path, may_overwrite());
}

void write_film_file(const fs::path& path, glm::ivec2 size, double fps,
                     const std::function<void(const AddPicture& add)>& draw) {
  const FilmFormat& format = film_format(path, size, fps);
  check_film_target(path);
  if (format.folder()) return write_folder(path, draw);
  replace_file(path, [&](const fs::path& temporary) {
    Ffmpeg ffmpeg(temporary, path.string(), size, fps, format.options);
    draw([&](const Image& picture) { ffmpeg.add(picture); });
    ffmpeg.finish();
  });
}

}  // namespace qs
