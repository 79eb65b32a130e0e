// SPDX-License-Identifier: MIT
#include "app/film/film.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <memory>
#include <span>
#include <system_error>

#include <fmt/format.h>
#include <glm/gtc/constants.hpp>
#include <sys/socket.h>
#include <unistd.h>

#include "app/framing/camera_control.h"
#include "app/inspect/comparison_sheet.h"
#include "app/inspect/heatmap_frame.h"
#include "app/measure/statistics.h"
#include "app/measure/turn_order.h"
#include "app/picture/canvas.h"
#include "app/picture/palette.h"
#include "base/child_process.h"
#include "base/fail.h"
#include "base/list_of.h"
#include "base/text.h"
#include "io/bytes/file_guard.h"
#include "io/bytes/replace_file.h"
#include "io/picture/image_file.h"
#include "io/picture/panorama_tag.h"

namespace qs {
namespace {

constexpr double kTurn = 2 * glm::pi<double>();

// Begins and ends with speed 0.
double eased(double share) { return share * share * (3 - 2 * share); }

constexpr const char* kWidestLine = "00,000,000 pairs";
constexpr float kPlateOpacity = 0.7f;

// The plate of the labels has the same width in the whole film.
int plate_width(const Font& font, const std::vector<StripName>& names) {
  int widest = font.width(kWidestLine);
  for (const StripName& name : names) widest = std::max(widest, font.width(name.text));
  return widest + font.line_height();
}

// The height of letters: easy to read, but a label must fit into a strip.
int letter_height(const std::vector<StripName>& names, int width, int height) {
  constexpr int kLeast = 8;
  const int room = width / static_cast<int>(names.size());
  int letter = std::max(height / 22, kLeast);
  const int needed = plate_width(Font(letter), names);
  if (needed > room) letter = std::max(letter * room / needed + 1, kLeast);
  while (letter > kLeast && plate_width(Font(letter), names) > room)
    --letter;  // widths are rounded
  return letter;
}

// The lines, broken between words where they are wider than `room`.
std::vector<std::string> wrapped(const Font& font, const std::vector<std::string>& lines,
                                 int room) {
  std::vector<std::string> rows;
  for (const std::string& line : lines) {
    rows.emplace_back();
    for (const std::string& word : separated(line, ' ')) {
      std::string& row = rows.back();
      const std::string longer = row + (row.empty() ? "" : " ") + word;
      if (row.empty() || font.width(longer) <= room) {
        row = longer;
      } else {
        rows.push_back(word);
      }
    }
  }
  return rows;
}

// The frame times and pair counts of a strip so far.
struct Numbers {
  std::vector<double> frame_ms, tile_pairs;

  void add(const RenderStats& stats) {
    frame_ms.push_back(static_cast<double>(stats.frame_ms));
    tile_pairs.push_back(static_cast<double>(stats.tile_pairs));
  }
  double recent_ms(std::size_t most) const {
    return median(std::span(frame_ms).last(std::min(most, frame_ms.size())));
  }
};

// `ms`: of the frames of the last second.
std::vector<std::string> lines_of(const RenderStats& stats, const FilmPlan& plan, std::size_t way,
                                  double ms) {
  std::vector<std::string> lines = {fmt::format("~{} FPS", rough(1000 / std::max(ms, 1e-6)))};
  if (stats.tile_pairs > 0) lines.push_back(grouped(stats.tile_pairs) + " pairs");
  const Backend backend = stats.threads > 0 ? Backend::cpu : Backend::cuda;
  lines.push_back(fmt::format("{} x {}", plan.size.x, plan.size.y));
  lines.push_back(drawn_by({plan.ways[way].settings.mode, stats.pipeline, backend}));
  if (!plan.altered_brief.empty()) lines.push_back(plan.altered_brief);
  return lines;
}

Camera camera_at(const FilmPlan& plan, int index) {
  return camera_of(plan.track, index, plan.frames(), plan.size);
}

const Frame& frame_of(const FilmPlan& plan, const FilmedBy& way, int index, std::stop_token stop,
                      Quantity quantity) {
  Outputs outputs = outputs_for(quantity);
  outputs.color = quantity == Quantity::color;
  return way.renderer->render(camera_at(plan, index), way.settings, outputs, HostImage{},
                              std::move(stop));
}

// Collects values_of(index) of pictures spread over the whole film.
template <class Value, class ValuesOf>
std::vector<Value> sampled_values(const FilmPlan& plan, const Progress& progress,
                                  const ValuesOf& values_of) {
  constexpr int kMost = 16;
  const int count = std::min(plan.frames(), kMost);
  std::vector<Value> all;
  for (int i = 0; i < count; ++i) {
    progress.update(static_cast<float>(i) / static_cast<float>(count));
    const auto& values = values_of(count == 1 ? 0 : i * (plan.frames() - 1) / (count - 1));
    all.insert(all.end(), values.begin(), values.end());
  }
  return all;
}

/// A frame in its strip.
struct ShownWay {
  RenderStats stats;
  std::optional<Legend> legend;  ///< the legend of the frame's map
};

ShownWay show_heatmap(SplitScreen& screen, std::size_t k, const FilmPlan& plan, int index,
                      const std::stop_token& stop) {
  const FilmHeatmap& heat = *plan.heatmap;
  const FilmedBy& way = plan.ways[k];
  HeatmapFrame mapped = render_with_heatmap(*way.renderer, camera_at(plan, index), way.settings,
                                            heat.quantity, *heat.pool, stop);
  Heatmap& map = mapped.heatmap;
  screen.show(k, draw_over(mapped.frame.color, map, heat.scale, heat.style));
  map.largest = std::numeric_limits<std::uint32_t>::max();  // any picture may exceed the scale
  return {mapped.frame.stats, make_legend(map, heat.scale, "", heat.style.colors)};
}

/// Draws picture `index` of way `k` into its strip.
ShownWay show_way(SplitScreen& screen, std::size_t k, const FilmPlan& plan, int index,
                  const std::stop_token& stop) {
  if (plan.heatmap) return show_heatmap(screen, k, plan, index, stop);
  const Frame& frame = frame_of(plan, plan.ways[k], index, stop, plan.quantity);
  if (plan.quantity == Quantity::color) {
    screen.show(k, frame.color);
    return {frame.stats, std::nullopt};
  }
  ValueMap map = map_of(frame, plan.quantity, plan.size.x, plan.size.y);
  map.scale = plan.scale;
  screen.show(k, colored(map));
  return {frame.stats, make_legend(map, "")};
}

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

constexpr const char* kTagged = ".mp4";  // has the boxes of panoramas

const FilmFormat kFormats[] = {
    {kTagged, video("-c:v libx264 -crf 18 -movflags +faststart"), true},
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
  if (found == std::end(kFormats))
    fail(
        ErrorKind::usage,
        "{}: a film ends in .mp4, .webm or .gif; a name without an ending is a folder of PNG files",
        path.string());
  if (found->even_size && (size.x % 2 != 0 || size.y % 2 != 0))
    fail(ErrorKind::usage, "{}: {} needs an even width and height, but the size is {} x {}",
         path.string(), ending, size.x, size.y);
  if (fps > found->most_fps)
    fail(ErrorKind::usage, "{}: {} holds at most {} pictures per second", path.string(), ending,
         found->most_fps);
  if (!found->folder() && !ffmpeg_is_installed())
    fail(ErrorKind::device,
         "{}: ffmpeg encodes films and is not installed; a name without an ending, such as {}, is "
         "a folder of PNG files and does not need it",
         path.string(), path.stem().string());
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
    std::ranges::transform(picture.values, bytes_.begin(), to_8bit);
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

void write_folder(const fs::path& path, const std::function<void(const AddPicture& add)>& draw,
                  const ImageMetadata& metadata) {
  int count = 0;
  replace_folder(path, [&](const fs::path& hidden) {
    draw([&](const Image& picture) {
      naming(path, hidden, [&] { write_image(picture, hidden / picture_name(count), metadata); });
      ++count;
    });
  });
  std::error_code ignored;
  while (is_own_report(path / picture_name(count)))
    fs::remove(path / picture_name(count++), ignored);
}

}  // namespace

bool ffmpeg_is_installed() {
  const char* folders = std::getenv("PATH");
  for (const std::string& folder : separated(folders == nullptr ? "" : folders, ':'))
    if (!folder.empty() && access((folder + "/ffmpeg").c_str(), X_OK) == 0) return true;
  return false;
}

bool tags_panorama(const fs::path& path) {
  const std::string ending = picture_extension(path);
  return ending.empty() || ending == kTagged;
}

void check_film(const fs::path& path, glm::ivec2 size, double fps) {
  checked_format(path, size, fps);
}

void write_film_file(const fs::path& path, glm::ivec2 size, double fps,
                     const std::function<void(const AddPicture& add)>& draw,
                     const std::string& altered, const std::optional<PanoramaFilm>& panorama) {
  FilmFormat format = checked_format(path, size, fps);
  if (format.folder()) {
    ImageMetadata metadata;
    if (!altered.empty()) metadata["Altered"] = altered;
    if (panorama && !panorama->is_stereo)
      metadata[kXmpText] = panorama_xmp(size.x, size.y, panorama->is_half ? 180 : 360);
    return write_folder(path, draw, metadata);
  }
  if (!altered.empty())
    format.options.insert(format.options.end(), {"-metadata", "comment=Altered: " + altered});
  replace_file(path, [&](const fs::path& temporary) {
    Ffmpeg ffmpeg(temporary, path.string(), size, fps, format.options);
    draw([&](const Image& picture) { ffmpeg.add(picture); });
    ffmpeg.finish();
    if (panorama && format.ending == kTagged) add_panorama_boxes(temporary, path, *panorama);
  });
}

CameraTrack turntable(const Framing& framing, const Arc& arc, Ease ease,
                      const std::optional<SceneBox>& box) {
  const double middle = 0.5 * (arc.low + arc.high), half = 0.5 * (arc.high - arc.low);
  const double phase = half > 0 ? std::asin(std::clamp(-middle / half, -1.0, 1.0)) : 0;
  return {kTurntableSeconds, true, [=](double share, glm::ivec2 size) {
            const double turn = kTurn * (ease == Ease::none ? share : eased(share));
            const double angle = arc.whole() ? turn : middle + half * std::sin(phase + turn);
            const double aspect = static_cast<double>(size.x) / size.y;
            const Framing shown = box ? whole_subject(framing, *box, arc, aspect) : framing;
            return orbited(framed_camera(shown, size.x, size.y), shown.target, shown.up, angle, 0);
          }};
}

CameraTrack turntable_of(const GaussianCloud& cloud, const std::vector<Camera>& cameras,
                         const Framing& framing, const TurntableWish& wish, ThreadPool& pool) {
  const SceneBox box = subject_box(cloud);
  if (wish.arc) return turntable(framing, *wish.arc, wish.ease, box);
  const Arc free = free_arc(cameras, cloud, framing, pool);
  const double aspect = static_cast<double>(wish.size.x) / wish.size.y;
  return turntable(framing, clear_arc(free, whole_subject(framing, box, free, aspect), cloud),
                   wish.ease, box);
}

CameraTrack along(std::vector<Keyframe> keyframes, Ease ease, bool closed) {
  for (Keyframe& keyframe : keyframes) keyframe.eases = keyframe.eases || ease == Ease::all;
  if (ease == Ease::ends) keyframes.front().eases = true;
  if (ease == Ease::ends && !closed) keyframes.back().eases = true;
  const double begin = keyframes.front().time;
  const double seconds = closed ? closed_length(keyframes) : keyframes.back().time - begin;
  const auto path = std::make_shared<const std::vector<Keyframe>>(closed ? closed_path(keyframes)
                                                                         : std::move(keyframes));
  return {seconds, closed, [=](double share, glm::ivec2 size) {
            return camera_at(*path, begin + share * seconds).resized(size.x, size.y);
          }};
}

Camera camera_of(const CameraTrack& track, int index, int count, glm::ivec2 size) {
  const int steps = std::max(track.closed ? count : count - 1, 1);
  return track.at(static_cast<double>(index) / steps, size);
}

SplitScreen::SplitScreen(std::vector<StripName> names, int width, int height)
    : names_(std::move(names)),
      picture_(width, height, 3),
      font_(letter_height(names_, width, height)) {}

PixelRect SplitScreen::strip(std::size_t index) const {
  const auto edge = [&](std::size_t i) {
    return static_cast<int>(i * static_cast<std::size_t>(picture_.width) / names_.size());
  };
  return {edge(index), 0, edge(index + 1) - edge(index), picture_.height};
}

void SplitScreen::show(std::size_t index, const Image& view) {
  const PixelRect part = strip(index);
  for (int y = 0; y < part.height; ++y)
    std::copy_n(view.row(y) + 3 * part.x, 3 * part.width, picture_.row(y) + 3 * part.x);
}

void SplitScreen::label(std::size_t index, const std::vector<std::string>& texts) {
  const PixelRect part = strip(index);
  const int line = font_.line_height(), margin = line / 2;
  const int width = plate_width(font_, names_);
  if (width > part.width) return;
  const std::vector<std::string> lines = wrapped(font_, texts, width - line);
  const int height = static_cast<int>(lines.size() + 1) * line + margin;
  const int left = part.x + (part.width - width) / 2;
  int top = part.height - height - margin;
  fill_polygon(picture_, corners_of({left, top}, {left + width, top + height}), on_dark::kPanel,
               kPlateOpacity);
  top += margin / 2;
  const StripName& name = names_[index];
  const int middle = left + width / 2;
  draw_text(picture_, font_, {middle, top}, name.text, name.color, Align::center);
  for (const std::string& text : lines)
    draw_text(picture_, font_, {middle, top += line}, text, on_dark::kText, Align::center);
}

Image& SplitScreen::picture() {
  const int width = std::max(picture_.height / 360, 1);
  for (std::size_t i = 1; i < names_.size(); ++i)
    fill_rect(picture_, {strip(i).x - width / 2, 0, width, picture_.height}, on_dark::kText);
  return picture_;
}

ValueScale film_scale(const FilmPlan& plan, const Progress& progress) {
  if (plan.quantity == Quantity::color || plan.quantity == Quantity::alpha) return {};
  const auto values_of = [&](int index) -> const std::vector<float>& {
    const Frame& frame = frame_of(plan, plan.ways.front(), index, progress.stop, plan.quantity);
    return frame.depth.*row_of(plan.quantity).values;
  };
  return scale_for(plan.quantity, sampled_values<float>(plan, progress, values_of));
}

Scale film_heat_scale(const FilmPlan& plan, CullMode baseline, const Progress& progress) {
  const FilmHeatmap& heat = *plan.heatmap;
  const FilmedBy& way = plan.ways.front();
  RenderSettings settings = way.settings;
  settings.mode = scale_mode(heat.quantity, baseline);
  Heatmap map;
  const auto values_of = [&](int index) -> const std::vector<std::uint32_t>& {
    map = render_with_heatmap(*way.renderer, camera_at(plan, index), settings, heat.quantity,
                              *heat.pool, progress.stop)
              .heatmap;
    return map.values;
  };
  return scale_for(sampled_values<std::uint32_t>(plan, progress, values_of));
}

std::vector<FilmedNumbers> write_film(const std::filesystem::path& path, const FilmPlan& plan,
                                      const Progress& progress) {
  const int count = plan.frames();
  const auto per_second = static_cast<std::size_t>(std::max(plan.fps, 1.0));
  const bool measures = plan.numbers || plan.ways.size() > 1;
  const bool draws_colors = plan.quantity == Quantity::color && !plan.heatmap;
  std::vector<Numbers> numbers(plan.ways.size());
  std::vector<StripName> names;
  for (const FilmedBy& way : plan.ways)
    names.push_back({way.name, on_dark::mode_color(way.settings.mode)});
  SplitScreen screen(std::move(names), plan.size.x, plan.size.y);
  TurnOrder order;
  const auto draw = [&](int i, const AddPicture& add) {
    std::optional<Legend> legend;
    for (const std::size_t k : order.next(plan.ways.size())) {
      ShownWay shown = show_way(screen, k, plan, i, progress.stop);
      legend = std::move(shown.legend);
      if (measures && !draws_colors)  // maps take time that the mode does not need
        shown.stats = frame_of(plan, plan.ways[k], i, progress.stop, Quantity::color).stats;
      numbers[k].add(shown.stats);
      if (plan.numbers)
        screen.label(k, lines_of(shown.stats, plan, k, numbers[k].recent_ms(per_second)));
    }
    Image& picture = screen.picture();
    if (legend) draw_legend_over(picture, *legend);
    add(picture);
    progress.update(static_cast<float>(i + 1) / static_cast<float>(count));
  };
  const auto draw_all = [&](const AddPicture& add) {
    if (plan.numbers)  // a renderer's first frame takes longer
      for (const FilmedBy& way : plan.ways) frame_of(plan, way, 0, progress.stop, Quantity::color);
    int drawn = 0;
    const auto keeps_part = [&](const std::string& problem) {
      return drawn > 0 && plan.keeps_part && plan.keeps_part(problem);
    };
    try {
      for (; drawn < count; ++drawn) draw(drawn, add);
    } catch (const Cancelled&) {
      if (!keeps_part("")) throw;
    } catch (const Error& error) {
      if (!keeps_part(error.what())) throw;
    }
  };
  write_film_file(path, plan.size, plan.fps, draw_all, plan.altered, plan.panorama);
  return list_of<FilmedNumbers>(numbers, [](const Numbers& way) {
    return FilmedNumbers{median(way.frame_ms), median(way.tile_pairs),
                         quartile_spread(way.frame_ms)};
  });
}

}  // namespace qs
