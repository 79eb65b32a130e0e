// SPDX-License-Identifier: MIT
//
// Films: a camera moves along a track, around a subject or along a path of keyframes, and every
// picture shows its view drawn in one or several ways: upright strips of the same view, each with
// the numbers of its frame.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "app/film/panorama_boxes.h"
#include "app/framing/whole_subject.h"
#include "app/measure/camera_path.h"
#include "app/picture/canvas.h"
#include "app/picture/heatmap.h"
#include "app/picture/value_map.h"
#include "raster/api/renderer.h"
#include "raster/scene/image.h"

namespace qs {

// Writes the pictures of a film to a file or folder, which appears whole or not at all. To add a
// format that ffmpeg can write: a row in film.cpp.

/// True if ffmpeg is on the PATH.
bool ffmpeg_is_installed();

/// Takes the next picture of a film: RGB, of the film's size.
using AddPicture = std::function<void(const Image& picture)>;

/// Throws Error: usage for an unknown extension, for a size or rate that the format cannot hold,
/// and if a command may not write a film to `path`, because it exists (io/bytes/file_guard.h);
/// device if the format needs ffmpeg and ffmpeg is not installed.
void check_film(const std::filesystem::path& path, glm::ivec2 size, double fps);

/// Calls draw(add), which adds the pictures in order, and moves the finished file or folder to
/// `path`. The name of `path` determines the format. A folder holds frame_00000.png and so on;
/// pictures of an earlier, longer film are removed. `altered` becomes the comment of a film, or
/// metadata of the pictures. With `panorama`, players show an .mp4 or the pictures as a panorama.
/// Throws Error, and the exceptions of draw().
void write_film_file(const std::filesystem::path& path, glm::ivec2 size, double fps,
                     const std::function<void(const AddPicture& add)>& draw,
                     const std::string& altered = {},
                     const std::optional<PanoramaFilm>& panorama = {});

/// True if players can show a film of this name as a panorama.
bool tags_panorama(const std::filesystem::path& path);

/// The places where the camera slows down to a stop, besides keyframes with `eases`: nowhere, at
/// the film's begin and end, or at every keyframe.
enum class Ease { none, ends, all };

/// Index = Ease.
inline constexpr const char* kEaseNames[] = {"none", "ends", "all"};

struct CameraTrack {
  double seconds = 0;   ///< its own duration
  bool closed = false;  ///< it ends at its begin
  /// `share`: of the duration, 0 to 1; `size`: of the picture.
  std::function<Camera(double share, glm::ivec2 size)> at;
};

inline constexpr double kTurntableSeconds = 10;

/// Circles around the framing's target, at the height and distance of its eye: a full circle, or
/// from one end of the arc to the other and back, like a pendulum. A turntable has no keyframes:
/// Ease::all means Ease::ends. With `box`, which has the size of the subject, the framing is
/// whole_subject() for the size of the picture.
CameraTrack turntable(const Framing& framing, const Arc& arc, Ease ease,
                      const std::optional<SceneBox>& box = {});

/// The turntable of a scene: its whole subject, along the angles from which a camera has a free
/// view of it outside of fog, or along `arc`. `size`: of the pictures. The pool is used until it
/// returns.
struct TurntableWish {
  std::optional<Arc> arc;
  Ease ease = Ease::none;
  glm::ivec2 size{1280, 720};
};
CameraTrack turntable_of(const GaussianCloud& cloud, const std::vector<Camera>& cameras,
                         const Framing& framing, const TurntableWish& wish, ThreadPool& pool);

/// Along the keyframes in their own times. At least two. `closed`: and back to the first keyframe,
/// see closed_path().
CameraTrack along(std::vector<Keyframe> keyframes, Ease ease, bool closed = false);

/// Camera `index` of `count` at equal time steps. The last camera is at the end of the track, or
/// one step before it if the track is closed, so that a film can be repeated.
Camera camera_of(const CameraTrack& track, int index, int count, glm::ivec2 size);

/// The name of a strip and its colour.
struct StripName {
  std::string text;
  glm::vec3 color{1.0f};  ///< on a dark ground
};

class SplitScreen {
 public:
  /// One strip per name, all equally wide.
  SplitScreen(std::vector<StripName> names, int width, int height);

  /// Copies strip `index` from a whole view.
  void show(std::size_t index, const Image& view);

  /// Writes the strip's name and these lines at its bottom, over the picture of show(). A strip
  /// that is too narrow for readable letters gets no label. Long lines are broken between words.
  void label(std::size_t index, const std::vector<std::string>& texts);

  /// The strips with lines between them. A caller may draw over them; show() replaces that.
  Image& picture();

 private:
  PixelRect strip(std::size_t index) const;

  std::vector<StripName> names_;
  Image picture_;
  Font font_;
};

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
  double seconds = 0, fps = 30;               ///< pictures per second
  std::vector<FilmedBy> ways;                 ///< at least one
  std::string altered;                        ///< of the scene, for the metadata; usually empty
  std::string altered_brief;                  ///< the same in the picture, below the numbers
  std::optional<PanoramaFilm> panorama = {};  ///< the pictures are panoramas
  bool numbers = false;                       ///< name, FPS and tile pairs are part of the picture
  Quantity quantity = Quantity::color;        ///< other quantities are drawn by a colour map
  ValueScale scale;                           ///< the scale of the colour map; see film_scale()
  std::optional<FilmHeatmap> heatmap;         ///< over the colours; only with Quantity::color
  /// Asked if the film is cancelled ("") or cannot be drawn or written any more: true keeps the
  /// pictures so far. Null: nothing is kept. A video whose encoder has ended is always lost.
  std::function<bool(const std::string& problem)> keeps_part = {};

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

/// Draws the film and writes it, see write_film_file(). Returns the numbers of each way; with
/// several ways, or with FilmPlan::numbers, they are measured with frames of colours alone. The FPS
/// in the picture are the median of the last second. Throws Error and Cancelled, and then leaves no
/// file.
std::vector<FilmedNumbers> write_film(const std::filesystem::path& path, const FilmPlan& plan,
                                      const Progress& progress);

}  // namespace qs
