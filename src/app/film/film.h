// SPDX-License-Identifier: MIT
//
// Films: a camera moves along a track, and every picture shows its view drawn in one or several
// ways.
#pragma once

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "app/film/camera_track.h"
#include "app/picture/heatmap.h"
#include "app/picture/value_map.h"
#include "raster/api/renderer.h"

namespace qs {

/// One way to draw the view. With several, each has a strip of the picture.
struct FilmedBy {
  Renderer* renderer = nullptr;
  RenderSettings settings;
  std::string name;
};

/// The heat maps over the pictures of a film. All ways and pictures share one scale.
struct FilmHeatmap {
  HeatQuantity quantity = HeatQuantity::pairs;
  Scale scale;  ///< see film_heat_scale()
  HeatStyle style;
  ThreadPool* pool = nullptr;  ///< compares frames for maps of missed contributions
};

struct FilmPlan {
  CameraTrack track;
  glm::ivec2 size{1280, 720};
  double seconds = 0, fps = 30;         ///< pictures per second
  std::vector<FilmedBy> ways;           ///< at least one
  bool numbers = false;                 ///< name, FPS and tile pairs are part of the picture
  Quantity quantity = Quantity::color;  ///< other quantities are drawn by a colour map
  ValueScale scale;                     ///< the scale of the colour map; see film_scale()
  std::optional<FilmHeatmap> heatmap;   ///< over the colours; only with Quantity::color

  /// Number of pictures, at least 1.
  int frames() const { return std::max(static_cast<int>(std::lround(seconds * fps)), 1); }
};

/// Medians over a film.
struct FilmedNumbers {
  double frame_ms = 0, tile_pairs = 0;
  std::optional<double> ms_spread;  ///< quartile_spread() of the frames; unset for one frame
};

/// The scale that fits the quantity of `plan` in pictures spread over the whole film. Throws Error
/// and Cancelled.
ValueScale film_scale(const FilmPlan& plan, const Progress& progress);

/// The scale that fits the heat map of `plan` in pictures spread over the whole film. They are
/// drawn by the renderer of the first way in mode `baseline`, see scale_mode(). Throws Error and
/// Cancelled.
Scale film_heat_scale(const FilmPlan& plan, CullMode baseline, const Progress& progress);

/// Draws the film and writes it, see film_file.h. Returns the numbers of each way; with several
/// ways, or with FilmPlan::numbers, they are measured with frames of colours alone. The FPS in the
/// picture are the median of the last second. Throws Error and Cancelled, and then leaves no file.
std::vector<FilmedNumbers> write_film(const std::filesystem::path& path, const FilmPlan& plan,
                                      const Progress& progress);

}  // namespace qs
