// SPDX-License-Identifier: MIT
#include "app/film/film_format.h"

#include <algorithm>
#include <cctype>
#include <cstdlib>

#include <unistd.h>

#include "base/fail.h"
#include "base/text.h"

namespace qs {
namespace {

// Films are sRGB, and players expect the colour matrix of HD television.
std::vector<std::string> video(const std::string& codec) {
  return separated(
      "-vf scale=out_color_matrix=bt709:out_range=tv,format=yuv420p -colorspace bt709 "
      "-color_range tv -color_primaries bt709 -color_trc iec61966-2-1 " +
          codec,
      ' ');
}

const std::vector<FilmFormat>& formats() {
  static const std::vector<FilmFormat> kFormats = {
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
  return kFormats;
}

std::string lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

}  // namespace

bool ffmpeg_is_installed() {
  const char* folders = std::getenv("PATH");
  for (const std::string& folder : separated(folders == nullptr ? "" : folders, ':')) {
    if (!folder.empty() && access((folder + "/ffmpeg").c_str(), X_OK) == 0) return true;
  }
  return false;
}

const FilmFormat& film_format(const std::filesystem::path& path, glm::ivec2 size, double fps) {
  const std::string ending = lower(path.extension().string());
  const auto found = std::find_if(formats().begin(), formats().end(),
                                  [&](const FilmFormat& row) { return row.ending == ending; });
  if (found == formats().end()) {
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
  return *found;
}

}  // namespace qs
