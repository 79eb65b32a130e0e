// SPDX-License-Identifier: MIT
//
// quadsplat eval: views x culling modes against photographs -> PSNR and SSIM, per view and mean.
// A view is rendered at its camera's size, clamped to 0..1 and area-averaged to its photograph's
// size before they are compared.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "app/cli/command.h"
#include "app/cli/frame_options.h"
#include "app/cli/view_choice.h"
#include "app/measure/shard.h"
#include "app/report/eval_report.h"
#include "app/report/stats_file.h"
#include "app/report/write_report.h"
#include "app/session/photographs.h"
#include "app/session/progress_bar.h"
#include "io/camera/cameras.h"
#include "io/picture/image_file.h"
#include "raster/base/fail.h"
#include "raster/scene/image_metrics.h"

namespace qs {
namespace {

struct EvalCommand {
  FrameOptions frame;
  std::optional<std::filesystem::path> images, save, csv, json, out_dir;
  Shard shard;
  int holdout = 0, images_scale = 1;
  std::string save_format = "png";
};

// A camera and its photograph.
struct View {
  Camera camera;
  std::filesystem::path photograph;
};

// The views of a run, and where they come from.
struct Views {
  std::filesystem::path cameras;
  std::vector<View> list;
  std::size_t skipped = 0;  ///< cameras without a photograph
};

bool parse(EvalCommand& command, Arguments arguments) {
  static constexpr const char* kSaveFormats[] = {"png", "ppm", "pfm"};
  Options options("eval", "measures PSNR and SSIM against photographs");
  declare_frame_options(options, command.frame);
  options.text("--images", "DIR", command.images,
               "the photographs, named as the cameras; any picture format");
  options.integer("--holdout", "N", 1, 1'000'000, command.holdout,
                  "only test views: every Nth by name, from the first (3DGS: 8; default: all)");
  options.integer("--images-scale", "N", 1, 64, command.images_scale,
                  "compares at 1/N of the photographs' size");
  options.text("--out-dir", "DIR", command.out_dir, "folder for eval.csv and eval.json");
  options.text("--csv", "FILE", command.csv, "one row per view and mode; - = stdout");
  options.text("--json", "FILE", command.json,
               "means, views, method and environment; - = stdout. LPIPS is not among them: the "
               "weights of its network cannot be shipped");
  options.value("--shard", "I/N", "evaluates every N-th view from the I-th; see quadsplat merge",
                [&](const std::string& text) { command.shard = parse_shard("--shard", text); });
  options.text("--save", "DIR", command.save,
               "writes every render, and the photographs as they were compared");
  options.choice(
      "--save-format", {std::begin(kSaveFormats), std::end(kSaveFormats)},
      [&](int chosen) { command.save_format = kSaveFormats[chosen]; },
      "of --save (default: png); pfm keeps values exactly");
  options.example("quadsplat eval garden/ --images garden/images_4 --holdout 8",
                  "a trained model on its test views");
  options.example("quadsplat eval plush.spz --images plush/images --cull all --csv quality.csv",
                  "what the culling modes cost in quality");
  if (!options.parse(arguments)) return false;
  if (!command.images)
    fail(ErrorKind::usage, "eval: --images is missing (see 'quadsplat eval --help')");
  if (command.csv == "-" && command.json == "-")
    fail(ErrorKind::usage, "eval: --csv and --json cannot both go to stdout");
  return true;
}

// The views to evaluate, by name.
Views choose_views(const EvalCommand& command) {
  const auto file =
      command.frame.cameras
          ? command.frame.cameras
          : find_cameras_file(find_scene_file(command.frame.scene, command.frame.iteration));
  if (!file) {
    fail("{}: no cameras were found beside it: name their file with --cameras",
         command.frame.scene.string());
  }
  std::vector<Camera> cameras = read_cameras(*file);
  std::stable_sort(cameras.begin(), cameras.end(),
                   [](const Camera& a, const Camera& b) { return a.name < b.name; });
  const Photographs photographs(*command.images);
  const auto step = static_cast<std::size_t>(std::max(1, command.holdout));
  Views views{*file, {}, 0};
  for (std::size_t i = 0; i < cameras.size(); i += step) {
    Camera camera = cameras[i];
    if (command.frame.size) camera = camera.resized(command.frame.size->x, command.frame.size->y);
    if (const auto photograph = photographs.find(camera.name)) {
      views.list.push_back({camera, *photograph});
    } else {
      ++views.skipped;
    }
  }
  if (views.list.empty()) {
    fail("{}: none of the {} views of {} has a photograph of its name there",
         command.images->string(), views.skipped, file->string());
  }
  return views;
}

// Photographs may be smaller or larger, but show the same picture: equal up to rounded sizes.
void require_same_shape(const Image& photograph, const View& view) {
  const double scale = static_cast<double>(photograph.width) / view.camera.width;
  const double height = scale * view.camera.height;
  if (std::abs(height - photograph.height) <= 1 + scale) return;
  fail("{}: {} x {} pixels are not the shape of its camera, {} x {}", view.photograph.string(),
       photograph.width, photograph.height, view.camera.width, view.camera.height);
}

class Run {
 public:
  explicit Run(const EvalCommand& command) : command_(command) {}

  void all_views() {
    const Views views = choose_views(command_);
    if (views.skipped > 0) {
      fmt::print(stderr, "quadsplat: {} view{} without a photograph {} left out\n", views.skipped,
                 views.skipped == 1 ? "" : "s", views.skipped == 1 ? "is" : "are");
    }
    session_ = open_session(command_.frame);
    report_ = {environment_json(session_),
               scene_json(*session_.scene),
               method(views),
               views.list.size(),
               {}};
    if (command_.save) make_folder(*command_.save);
    {
      ProgressBar bar("evaluating");
      const Progress progress = bar.progress();
      for (std::size_t i = 0; i < views.list.size(); ++i) {
        if (command_.shard.takes(i)) one_view(views.list[i], i);
        progress.update(static_cast<float>(i + 1) / static_cast<float>(views.list.size()));
      }
    }
    const bool to_stdout = command_.csv == "-" || command_.json == "-";
    fmt::print(to_stdout ? stderr : stdout, "{}", format_eval_table(report_));
    if (command_.csv) write_stats(*command_.csv, format_eval_csv(report_));
    if (command_.json) write_stats(*command_.json, format_eval_json(report_));
    if (command_.out_dir) write_eval_report(report_, *command_.out_dir);
  }

 private:
  nlohmann::ordered_json method(const Views& views) const {
    return {
        {"cameras", views.cameras.string()},
        {"images", command_.images->string()},
        {"holdout", command_.holdout},
        {"images_scale", command_.images_scale},
        {"views_without_photograph", views.skipped},
        {"psnr", "-10 log10(mean squared error of all RGB values), peak 1, mean over views"},
        {"ssim", "Gaussian window 11 x 11, sigma 1.5, zeros outside, K 0.01 and 0.03, per channel"},
        {"sizes", "rendered at the camera's size, clamped, area-averaged to the photograph's"}};
  }

  void one_view(const View& view, std::size_t number) {
    const Image photograph = read_photograph(view.photograph, session_.settings.background,
                                             command_.images_scale, *session_.pool);
    require_same_shape(photograph, view);
    save(photograph, view, "photograph");
    for (const CullMode mode : command_.frame.modes) {
      session_.settings.mode = mode;
      Image image = session_.renderer->render(view.camera, session_.settings).color;
      save(image, view, mode_name(mode));
      clamp_to_unit(image);
      image = area_average(image, photograph.width, photograph.height, *session_.pool);
      report_.rows.push_back({view.camera, view.photograph, photograph.width, photograph.height,
                              mode, psnr(image, photograph, *session_.pool),
                              ssim(image, photograph, *session_.pool), number});
    }
  }

  // DIR/view_NAME_WHAT.png
  void save(const Image& image, const View& view, const char* what) const {
    if (!command_.save) return;
    const std::filesystem::path path = *command_.save / ("view." + command_.save_format);
    write_image(image, with_word(with_word(path, view.camera.name), what));
  }

  const EvalCommand& command_;
  Session session_;
  EvalReport report_;
};

}  // namespace

int run_eval(Arguments arguments) {
  EvalCommand command;
  if (!parse(command, arguments)) return kExitOk;
  Run(command).all_views();
  return kExitOk;
}

}  // namespace qs
