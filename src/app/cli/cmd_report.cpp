// SPDX-License-Identifier: MIT
//
// quadsplat report: a page about the cost of rendering a scene and the work that each mode saves.
#include <cstdio>
#include <map>
#include <memory>

#include "app/cli/camera_choice.h"
#include "app/cli/command.h"
#include "app/framing/scene_box.h"
#include "app/inspect/construction.h"
#include "app/inspect/heatmap_frame.h"
#include "app/measure/scene_facts.h"
#include "app/picture/heatmap.h"
#include "app/report/study_page.h"
#include "app/session/alterations.h"
#include "base/environment.h"
#include "base/fail.h"
#include "base/list_of.h"
#include "base/path_kind.h"
#include "base/progress_bar.h"
#include "io/bytes/file_guard.h"
#include "io/bytes/file_hash.h"
#include "io/bytes/replace_file.h"
#include "raster/scene/image_metrics.h"

namespace qs {
namespace {

constexpr int kPictureWidth = 800;

struct ReportCommand {
  FrameOptions frame;
  CameraChoice cameras;
  std::filesystem::path output;
  int views = 4;
};

std::vector<Shot> choose_views(const ReportCommand& command, const Session& session) {
  const std::vector<Shot> all = choose_shots_or_all(command.cameras, command.frame, session);
  const std::size_t count = std::min(all.size(), static_cast<std::size_t>(command.views));
  std::vector<Shot> shots;
  for (std::size_t i = 0; i < count; ++i) shots.push_back(all[i * all.size() / count]);
  return shots;
}

// The page's file. Checked before the work, which takes a minute.
std::filesystem::path output_file(const std::filesystem::path& output) {
  if (output.extension() == ".html") {
    check_targets({output});
    return output;
  }
  if (output.has_extension() && !is_folder(output))
    fail(ErrorKind::usage,
         "{}: a report ends in .html; a name without an ending is a folder for report.html",
         output.string());
  check_folder(output);
  check_target(output / "report.html");
  return output / "report.html";
}

class Report {
 public:
  explicit Report(const ReportCommand& command)
      : path_(output_file(command.output)),
        session_(open_session(command.frame)),
        shots_(choose_views(command, session_)) {}

  int run() {
    const auto cameras = list_of<Camera>(shots_, &Shot::camera);
    ProgressBar bar("studying");
    SceneStudy study =
        study_scene(*session_.renderer, cameras, session_.settings, *session_.pool, bar.progress());
    study.huge = count_huge(session_.scene->cloud);
    const std::string name = scene_name(session_.scene->path);
    const StudyPage page{study,      name,           view_names(), plots_caption(name),
                         pictures(), example(study), made_with()};
    std::string problem;
    const std::string html = format_study_page(page, problem);
    if (!problem.empty()) warn("report: no plots: " + problem);
    if (path_.has_parent_path()) make_folder(path_.parent_path());
    write_text(path_, html);
    fmt::print(stderr, "wrote {} ({})\n", path_.string(), bytes_text(html.size()));
    return kExitOk;
  }

 private:
  std::string size() const {
    const Camera& first = shots_.front().camera;
    return fmt::format("{} x {} pixels", first.width, first.height);
  }

  std::string view_names() const {
    return joined(list_of<std::string>(shots_, &Shot::origin), ", ") + ", " + size();
  }

  std::string plots_caption(const std::string& name) const {
    return fmt::format("{}, {} view{}, {}{}", name, shots_.size(), shots_.size() == 1 ? "" : "s",
                       size(), altered_clause(session_));
  }

  const Frame& render(CullMode mode, const Outputs& outputs) {
    RenderSettings settings = session_.settings;
    settings.mode = mode;
    return session_.renderer->render(shots_.front().camera, settings, outputs);
  }

  CaptionedImage small(const Image& image, const std::string& caption) {
    if (image.width <= kPictureWidth) return {image, caption};
    Image clamped = image;
    clamp_to_unit(clamped);
    return {area_average(clamped, kPictureWidth, image.height * kPictureWidth / image.width,
                         *session_.pool),
            caption};
  }

  // A heat map of the first view. The maps of one quantity in several modes share their scale.
  struct Map {
    CullMode mode;
    HeatQuantity quantity;
    const char* caption;
    Image color = {};
    Heatmap heatmap = {};
  };

  std::vector<CaptionedImage> pictures() {
    const CullMode square = find_culler("3dgs"), dual = find_culler("dualbox");
    Map maps[] = {
        {square, HeatQuantity::pairs, "its tile pairs."},
        {default_mode(), HeatQuantity::pairs, "its tile pairs."},
        {default_mode(), HeatQuantity::evaluated, "the list entries that each pixel evaluates."},
        {default_mode(), HeatQuantity::false_positive, "its false positive pairs."},
        {dual, HeatQuantity::missed,
         "the contributions that it drops, because it lists two of the four boxes."}};
    std::vector<CaptionedImage> pictures = {
        small(render(default_mode(), {}).color, shots_.front().origin)};
    std::map<HeatQuantity, std::vector<std::uint32_t>> values;
    ProgressBar bar("drawing heat maps");
    const Progress progress = bar.progress();
    for (Map& map : maps) {
      RenderSettings settings = session_.settings;
      settings.mode = map.mode;
      HeatmapFrame drawn = render_with_heatmap(*session_.renderer, shots_.front().camera, settings,
                                               map.quantity, *session_.pool);
      map.color = drawn.frame.color;
      map.heatmap = std::move(drawn.heatmap);
      progress.update(static_cast<float>(&map - maps + 1) / static_cast<float>(std::size(maps)));
      std::vector<std::uint32_t>& all = values[map.quantity];
      all.insert(all.end(), map.heatmap.values.begin(), map.heatmap.values.end());
    }
    for (const Map& map : maps) {
      const char* name = mode_name(map.mode);
      const Scale scale = scale_for(values[map.quantity]);
      pictures.push_back(small(draw_heatmap(map.color, map.heatmap, scale, name),
                               fmt::format("{}: {}", name, map.caption)));
    }
    return pictures;
  }

  std::vector<CaptionedImage> example(const SceneStudy& study) {
    if (study.example.saved == 0) return {};
    const Shot& shot = shots_[study.example.view];
    const Frame& frame =
        session_.renderer->render(shot.camera, session_.settings, inspection_outputs());
    const std::optional<std::size_t> slot = slot_of(frame.trace, study.example.gaussian);
    if (!slot) return {};
    const glm::ivec2 size(shot.camera.width, shot.camera.height);
    const glm::vec2 mean = frame.trace.footprints[*slot].mean_px;
    const glm::ivec2 pixel(clamp_to_int(mean.x + 0.5f, size.x - 1),
                           clamp_to_int(mean.y + 0.5f, size.y - 1));
    const Inspection inspection =
        inspect(frame, size, pixel, session_.settings.background, study.example.gaussian);
    const std::string title = picture_title(session_.scene->path, shot.origin);
    return {{draw_construction({inspection, frame.color, frame.grid, title}),
             "Its ellipse, the boxes of the modes, and the tiles that each mode lists."}};
  }

  std::string made_with() const {
    const Environment environment = read_environment();
    return fmt::format(
        "quadsplat {} (commit {}) on {}, {}, with {} threads. Scene file {}, {}{}. Counts do not "
        "depend on the machine; times do. 'quadsplat report' makes this page again; 'quadsplat "
        "inspect' shows any other pixel and Gaussian.",
        environment.version, environment.commit, environment.cpu, environment.utc,
        session_.pool->size(), session_.scene->path.filename().string(),
        file_hash(session_.scene->path), altered_clause(session_));
  }

  std::filesystem::path path_;
  Session session_;
  std::vector<Shot> shots_;
};

int run(ReportCommand& command) {
  if (command.frame.backend == Backend::cuda)
    fail(ErrorKind::usage,
         "report: it studies several tile sizes, which runs with --backend cpu only");
  command.frame.backend = Backend::cpu;
  note_inputs(command.frame);
  return Report(command).run();
}

}  // namespace

CommandAction report_command(Options& options) {
  const auto command = std::make_shared<ReportCommand>();
  declare_frame_options(options, command->frame);
  declare_camera_choice(options, command->cameras);
  options.integer("--views", "N", 1, 100000, command->views,
                  "studies at most N of the cameras, evenly spread (default: 4)");
  options.text("--output", "FILE", command->output,
               "the page, FILE.html, or a folder for report.html", {"page.html", "out"});
  options.required();
  options.overwrite();
  options.example("quadsplat report plush.spz --cameras plush/cameras.json --output plush.html",
                  "what the Gaussians of a scene look like and what they cost");
  return [command](Arguments) { return run(*command); };
}

}  // namespace qs
