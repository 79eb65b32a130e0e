// SPDX-License-Identifier: MIT
//
// quadsplat eval: views x culling modes against photographs -> PSNR, SSIM and LPIPS, per view and
// mean.
// A view is rendered at its camera's size, clamped to 0..1 and area-averaged to its photograph's
// size before they are compared.
#include <algorithm>
#include <cstdio>
#include <memory>
#include <optional>
#include <utility>

#include "app/cli/command.h"
#include "app/cli/shared_options.h"
#include "app/measure/scene_facts.h"
#include "app/report/bench_report.h"
#include "app/report/environment.h"
#include "app/report/eval_report.h"
#include "app/session/shot.h"
#include "base/fail.h"
#include "base/progress_bar.h"
#include "base/text.h"
#include "io/bytes/file_guard.h"
#include "io/bytes/file_hash.h"
#include "io/bytes/replace_file.h"
#include "io/camera/cameras.h"
#include "io/camera/lens_views.h"
#include "io/camera/photographs.h"
#include "io/picture/image_file.h"
#include "learn/lpips/metric.h"
#include "raster/scene/image_metrics.h"

namespace qs {
namespace {

struct EvalCommand {
  FrameOptions frame;
  std::filesystem::path images;
  std::optional<std::filesystem::path> save, csv, json, out_dir, lpips;
  Shard shard;
  int holdout = 0, images_scale = 1;
  SsimBorder ssim_border = SsimBorder::zeros;
  std::string save_format = "png";
  bool exact_color = false, in_lens = false;
};

// A camera and its photograph.
struct EvalView {
  Camera camera;
  LensCamera taken;  ///< the camera in the cameras file
  std::filesystem::path photograph;
  bool is_first_face = true;  ///< of the photograph
};

// The views of a run and their cameras file.
struct Views {
  std::filesystem::path cameras;
  std::vector<EvalView> list;
  std::size_t skipped = 0;  ///< cameras without a photograph
  std::string used;         ///< a sentence about the data
  std::vector<std::string> warnings;
};

// The views to evaluate, sorted by name.
Views choose_views(const EvalCommand& command) {
  const FrameOptions& frame = command.frame;
  const auto file = cameras_file(frame, find_scene_file(frame.scene, frame.iteration));
  if (!file)
    fail("{}: no cameras were found beside it: name their file with --cameras",
         frame.scene.string());
  CameraSet set = read_camera_set(*file);
  std::vector<LensCamera>& cameras = set.cameras;
  sort_by_name(cameras);
  const Photographs photographs(command.images);
  const bool has_faces = std::ranges::any_of(cameras, &LensCamera::is_face);
  const auto found = find_pictures(photograph_names(cameras), {}, photographs, has_faces);
  const auto step = static_cast<std::size_t>(std::max(1, command.holdout));
  Views views{*file, {}, 0, "", set.sentences()};
  views.warnings.push_back(orientation_sentence(cameras, found));
  const auto missing = std::ranges::count(found, std::filesystem::path());
  views.used =
      used_sentence(set, found.size() - static_cast<std::size_t>(missing), photographs.folder());
  const std::vector<std::string> left_out = left_out_of(set, found, photographs);
  if (!left_out.empty()) views.used += "; left out: " + joined(left_out, ", ");
  std::size_t number = 0;  // of photographs; one may be divided into several cameras
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    if (i > 0 && !is_next_face(cameras, i)) ++number;
    if (number % step != 0) continue;
    if (found[i].empty()) {
      ++views.skipped;
      continue;
    }
    note_input(found[i]);  // some are read after pictures are written
    bool is_first = !is_next_face(cameras, i);
    for (const LensCamera& taken : views_of(cameras[i])) {
      Camera camera = compared_camera(taken.camera, taken.lens);
      if (frame.size) camera = camera.resized(frame.size->x, frame.size->y);
      views.list.push_back({camera, taken, found[i], std::exchange(is_first, false)});
    }
  }
  const auto has_lens = [](const EvalView& view) { return view.taken.lens.has_value(); };
  if (command.in_lens && std::ranges::none_of(views.list, has_lens))
    views.warnings.push_back("--lens-eval: no photograph has a lens that distorts");
  if (views.list.empty())
    fail("{}: holds no photograph named like one of the {} views of {}", command.images.string(),
         views.skipped, file->string());
  return views;
}

// Pixels that the photograph does not show are equal in both pictures, also for LPIPS.
void black_out(Image& image, const std::vector<std::uint8_t>& mask) {
  const auto channels = static_cast<std::size_t>(image.channels);
  for (std::size_t i = 0; i < mask.size(); ++i)
    if (mask[i] == 0) std::fill_n(&image.values[i * channels], channels, 0.0f);
}

class EvalRun {
 public:
  explicit EvalRun(const EvalCommand& command) : command_(command) {}

  void all_views() {
    Views views = choose_views(command_);
    lpips::Weights weights;
    if (command_.lpips) weights = read_lpips(*command_.lpips);
    network_ = weights.network;
    for (const std::string& sentence : views.warnings) warn(sentence);
    session_ = open_session(command_.frame);
    for (EvalView& view : views.list)
      view.camera = view.camera.placed(session_.scene->cloud.origin);
    if (network_ != nullptr)
      distance_ = make_lpips(session_.backend, weights, *session_.pool, session_.device);
    report_ = {
        environment_json(session_), scene_json(session_), method(views), views.list.size(), {}};
    if (command_.save) make_folder(*command_.save);
    fmt::print(stderr, "{}\n", views.used);
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
    if (command_.csv) write_text(*command_.csv, format_eval_csv(report_));
    if (command_.json) write_text(*command_.json, format_eval_json(report_));
    if (command_.out_dir) write_eval_report(report_, *command_.out_dir);
  }

 private:
  nlohmann::ordered_json method(const Views& views) const {
    nlohmann::ordered_json method = {
        {"cameras", views.cameras.string()},
        {"images", command_.images.string()},
        {"holdout", command_.holdout},
        {"images_scale", command_.images_scale},
        {"views_without_photograph", views.skipped},
        {"psnr", "-10 log10(mean squared error of all RGB values), peak 1, mean over views"},
        {"ssim", ssim_method(command_.ssim_border)},
        {"sizes", "rendered at the camera's size, clamped, area-averaged to the photograph's"}};
    if (command_.in_lens)
      method["in_lens"] =
          "the photograph as it was taken, and the view drawn through its lens at its camera's "
          "size, over the pixels that the lens shows";
    if (network_ != nullptr)
      method["lpips"] = {{"network", network_->name},
                         {"weights", command_.lpips->string()},
                         {"hash", file_hash(*command_.lpips)},
                         {"lpips_paper", "input 0..1, as in the published scripts of 3DGS"},
                         {"lpips", "input -1..1"}};
    return method;
  }

  void one_view(const EvalView& view, std::size_t number) {
    Image photograph = read_photograph(view.photograph, session_.settings.background,
                                       command_.images_scale, *session_.pool, view.taken);
    require_same_shape(photograph, view.photograph, {view.camera.width, view.camera.height});
    if (view.taken.is_face()) clamp_to_unit(photograph);  // bicubic interpolation overshoots
    const std::vector<std::uint8_t> mask =
        lens_mask(view.taken, photograph.width, photograph.height, *session_.pool);
    if (command_.ssim_border == SsimBorder::crop &&
        std::min(photograph.width, photograph.height) <= 2 * kSsimRadius) {
      fail(ErrorKind::usage,
           "--ssim-border crop: {} has {} x {} pixels, and {} at least are needed",
           view.photograph.string(), photograph.width, photograph.height, 2 * kSsimRadius + 1);
    }
    if (network_ != nullptr) require_size(photograph, view);
    save(photograph, view, "photograph");
    black_out(photograph, mask);
    std::vector<ComparedImage> compared;
    std::optional<Taken> own;
    if (command_.in_lens && view.is_first_face && view.taken.lens) own = taken(view);
    for (const CullMode mode : command_.frame.modes) {
      session_.settings.mode = mode;
      Image image = session_.renderer->render(view.camera, session_.settings).color;
      save(image, view, mode_name(mode));
      clamp_to_unit(image);
      image = area_average(image, photograph.width, photograph.height, *session_.pool);
      black_out(image, mask);
      report_.rows.push_back({view.camera, view.photograph, photograph.width, photograph.height,
                              mode, psnr(image, photograph, *session_.pool, mask),
                              ssim(image, photograph, *session_.pool, command_.ssim_border, mask),
                              number, lpips_of(image, photograph, compared),
                              own ? std::optional(quality_of(*own, view)) : std::nullopt});
      if (network_ != nullptr) compared.push_back({std::move(image), *report_.rows.back().lpips});
    }
  }

  // A photograph as it was taken, and the camera that draws it.
  struct Taken {
    Camera camera;
    std::shared_ptr<const LensView> lens;
    Image photograph;
    std::vector<std::uint8_t> mask;  // 1: the lens shows the whole pixel
  };

  Taken taken(const EvalView& view) {
    const Lens& lens = *view.taken.lens;
    Taken own{view.taken.taken().placed(session_.scene->cloud.origin),
              std::make_shared<const LensView>(photograph_view(lens)),
              divided(read_as_taken(view.photograph, session_.settings.background, view.taken),
                      command_.images_scale, *session_.pool),
              {}};
    Image shown(own.camera.width, own.camera.height, 1);
    const SizedLens sized = own.lens->sized({shown.width, shown.height});
    session_.pool->for_each(shown.values.size(), 256, [&](std::size_t at) {
      const auto width = static_cast<std::size_t>(shown.width);
      shown.values[at] = sized.direction({at % width, at / width}) ? 1.0f : 0.0f;
    });
    shown = area_average(shown, own.photograph.width, own.photograph.height, *session_.pool);
    constexpr float kWhole = 0.9999f;
    for (const float share : shown.values) own.mask.push_back(share > kWhole ? 1 : 0);
    black_out(own.photograph, own.mask);
    save(own.photograph, view, "lens_photograph");
    return own;
  }

  // Of the mode in the settings.
  LensQuality quality_of(const Taken& own, const EvalView& view) {
    RenderSettings settings = session_.settings;
    settings.lens = own.lens;
    Image image = session_.renderer->render(own.camera, settings).color;
    clamp_to_unit(image);
    image = area_average(image, own.photograph.width, own.photograph.height, *session_.pool);
    black_out(image, own.mask);
    save(image, view, fmt::format("lens_{}", mode_name(settings.mode)).c_str());
    return {psnr(image, own.photograph, *session_.pool, own.mask),
            ssim(image, own.photograph, *session_.pool, command_.ssim_border, own.mask),
            static_cast<double>(std::ranges::count(own.mask, 1)) /
                static_cast<double>(own.mask.size())};
  }

  // An image of the same view, and its LPIPS.
  struct ComparedImage {
    Image image;
    LpipsValues lpips;
  };

  // Images of lossless modes are equal, so one computation serves all of them.
  std::optional<LpipsValues> lpips_of(const Image& image, const Image& photograph,
                                      const std::vector<ComparedImage>& compared) const {
    if (network_ == nullptr) return std::nullopt;
    for (const ComparedImage& earlier : compared)
      if (earlier.image.values == image.values) return earlier.lpips;
    return LpipsValues{distance_(image, photograph, lpips::InputRange::unit),
                       distance_(image, photograph, lpips::InputRange::symmetric)};
  }

  void require_size(const Image& photograph, const EvalView& view) const {
    const int side = lpips::smallest_side(*network_);
    if (std::min(photograph.width, photograph.height) >= side) return;
    fail(ErrorKind::usage, "--lpips: {} has {} x {} pixels, and {} needs {} x {} at least",
         view.photograph.string(), photograph.width, photograph.height, network_->name, side, side);
  }

  // DIR/view_NAME_WHAT.png
  void save(const Image& image, const EvalView& view, const char* what) const {
    if (!command_.save) return;
    const std::filesystem::path path = *command_.save / ("view." + command_.save_format);
    write_image(image, with_word(with_word(path, view.camera.name), what),
                altered_metadata(session_));
  }

  const EvalCommand& command_;
  const lpips::Network* network_ = nullptr;  // null: no LPIPS
  LpipsDistance distance_;
  Session session_;
  EvalReport report_;
};

}  // namespace

CommandAction eval_command(Options& options) {
  static constexpr const char* kBorders[] = {"zeros", "crop"};  // names in the order of SsimBorder
  const auto command = std::make_shared<EvalCommand>();
  declare_frame_options(options, command->frame);
  declare_level_options(options, command->frame.levels);
  options.text("--images", "DIR", command->images,
               "folder of the photographs, named as the cameras; any picture format",
               {"images", "missing"});
  options.required();
  options.integer("--holdout", "N", 1, 1'000'000, command->holdout,
                  "only the test views: every N-th by name, from the first; 3DGS uses 8 (default: "
                  "all views)");
  options.integer("--images-scale", "N", 1, 64, command->images_scale,
                  "compares at 1/N of the photographs' size (default: 1)");
  options.enumerated(
      "--ssim-border", kBorders, command->ssim_border,
      "zeros: every pixel counts, values outside are 0; crop: without the 5 pixels at the border, "
      "as torchmetrics (default: zeros)");
  options.flag("--lens-eval", command->in_lens,
               "adds PSNR and SSIM of photographs as they were taken, against the view drawn "
               "through their lens, over the pixels that it shows");
  options.text("--lpips", "FILE", command->lpips,
               "adds LPIPS with the weights of this .safetensors file, which scripts/lpips_weights "
               "makes: for the network's input 0..1, as papers on 3DGS print it, and for -1..1",
               {"vgg16.safetensors"});
  declare_exact_color_option(options, command->exact_color, "every picture");
  options.text("--out-dir", "DIR", command->out_dir, "folder of eval.csv and eval.json", {"out"});
  options.text("--csv", "FILE", command->csv, "one row per view and mode; - = stdout",
               {"-", "eval.csv"});
  options.text("--json", "FILE", command->json, "means, views, method and environment; - = stdout",
               {"-", "eval.json"});
  options.overwrite();
  declare_shard_option(options, command->shard, "evaluates every N-th view, from the I-th");
  options.text("--save", "DIR", command->save,
               "writes every rendered image, and the photographs as they were compared", {"saved"});
  options.named("--save-format", {"png", "ppm", "pfm"}, command->save_format,
                "of --save; pfm keeps values exactly (default: png)");
  options.example("quadsplat eval garden/ --images garden/images_4 --holdout 8",
                  "a trained model on its test views");
  options.example("quadsplat eval plush.spz --images plush/images --cull all --csv quality.csv",
                  "what the culling modes cost in quality");
  return [command](Arguments) {
    if (command->csv == "-" && command->json == "-")
      fail(ErrorKind::usage, "eval: --csv and --json cannot both go to stdout");
    check_rules("eval", {{command->in_lens && command->frame.size.has_value(),
                          "--lens-eval draws at the size of the photographs' camera: leave out "
                          "--size"}});
    note_inputs(command->frame);
    if (command->exact_color) command->frame.network = NetworkUse::always;
    if (command->lpips) note_input(*command->lpips);
    check_report(command->out_dir, kEvalFiles);
    check_targets({command->csv, command->json});
    if (command->save) check_folder(*command->save);
    EvalRun(*command).all_views();
    return kExitOk;
  };
}

}  // namespace qs
