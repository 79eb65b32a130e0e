// SPDX-License-Identifier: MIT
//
// quadsplat judge: pictures of many views against the true pictures -> PSNR, SSIM and FLIP per
// view.
#include <algorithm>
#include <cstdio>
#include <memory>
#include <string>
#include <unordered_map>
#include <vector>

#include "app/cli/command.h"
#include "app/cli/judging.h"
#include "app/inspect/picture_pair.h"
#include "app/measure/scene_facts.h"
#include "app/report/bench_report.h"
#include "app/report/environment.h"
#include "app/report/eval_report.h"
#include "app/session/alterations.h"
#include "base/fail.h"
#include "base/path_kind.h"
#include "base/progress_bar.h"
#include "base/text.h"
#include "io/bytes/file_guard.h"
#include "io/bytes/replace_file.h"
#include "io/camera/photographs.h"
#include "io/picture/image_file.h"
#include "raster/scene/image_metrics.h"

namespace qs {
namespace {

constexpr int kSheetWidth = 480;  // pixels of a picture on the sheet

// Finds pictures by the names of views.
class PictureFolder {
 public:
  explicit PictureFolder(Photographs pictures) : pictures_(std::move(pictures)) {
    for (const std::string& name : pictures_.names()) {
      for (std::size_t at = name.find('_'); at != name.npos; at = name.find('_', at + 1)) {
        const auto [entry, added] = by_ending_.try_emplace(name.substr(at + 1), name);
        if (!added) entry->second.clear();
      }
    }
  }

  std::vector<std::string> names() const { return pictures_.names(); }

  // The picture of a view: NAME, or the only picture that ends with _NAME, as render names its
  // files.
  std::optional<std::filesystem::path> find(const std::string& view) const {
    if (const auto picture = pictures_.find(view)) return picture;
    const auto found = by_ending_.find(safe_file_name(view));
    if (found == by_ending_.end() || found->second.empty()) return std::nullopt;
    return pictures_.find(found->second);
  }

 private:
  Photographs pictures_;
  std::unordered_map<std::string, std::string> by_ending_;  // a name; empty: of several pictures
};

// One of the two sides: a folder of pictures or a scene.
struct Side {
  std::filesystem::path path;
  std::optional<PictureFolder> pictures;  // set: a folder of pictures
  Session session;                        // else the scene
};

// The pictures of a folder without a model; nothing for a scene. Throws Error(input) if it has
// neither.
std::optional<PictureFolder> open_pictures(const std::filesystem::path& path) {
  if (!is_folder(path) || holds_scene(path)) return std::nullopt;
  ProgressBar bar("counting pictures");
  const Progress progress = bar.progress();
  const Photographs pictures(path, [&](std::size_t count) {
    if (count % 100 != 0) return;
    bar.relabel(fmt::format("counting pictures: {}", grouped(count)));
    progress.update(0);
  });
  if (pictures.names().empty())
    fail("{}: a folder without pictures and without the scene of a model", path.string());
  return PictureFolder(pictures);
}

Side open_side(const JudgeOptions& options, const std::filesystem::path& path) {
  Side side{path, open_pictures(path), {}};
  if (side.pictures) return side;
  FrameOptions frame = options.frame;
  frame.scene = path;
  side.session = open_session(frame);
  return side;
}

using File = std::optional<std::filesystem::path>;  // unset for a scene

struct JudgedView {
  std::string name;
  std::optional<Camera> camera = {};  // unset if no side is a scene
  File truth = {}, judged = {};
};

class Judging {
 public:
  explicit Judging(const JudgeOptions& options)
      : options_(options),
        truth_(open_side(options, options.frame.scene)),
        judged_(open_side(options, options.judged)),
        pool_(options.frame.threads) {}

  void run() {
    if (options_.frame.network == NetworkUse::if_any && !has_network(truth_) &&
        !has_network(judged_)) {
      fail(ErrorKind::usage,
           "--exact-color: neither {} nor {} has a network of colours; only models of Compact-3DGS "
           "have one",
           truth_.path.string(), judged_.path.string());
    }
    result_.truth = truth_.path.string();
    result_.judged = judged_.path.string();
    const std::vector<JudgedView> views = choose_views();
    judge(views);
    sort_worst_first(result_.views);
    report(views.size());
  }

 private:
  static bool has_network(const Side& side) {
    return side.session.scene && side.session.scene->network;
  }

  const Side* scene() const {
    if (!truth_.pictures) return &truth_;
    return judged_.pictures ? nullptr : &judged_;
  }

  std::vector<JudgedView> choose_views() const {
    std::vector<JudgedView> views;
    std::size_t missing = 0;
    const auto take = [&](JudgedView view) {
      if (truth_.pictures) view.truth = truth_.pictures->find(view.name);
      if (judged_.pictures) view.judged = judged_.pictures->find(view.name);
      const bool found = view.truth.has_value() == truth_.pictures.has_value() &&
                         view.judged.has_value() == judged_.pictures.has_value();
      if (found) {
        views.push_back(std::move(view));
      } else {
        ++missing;
      }
    };
    if (const Side* side = scene()) {
      for (const Shot& shot :
           choose_shots_or_all(options_.cameras, options_.frame, side->session)) {
        const std::string& name = shot.camera.name;
        take({name.empty() ? shot.origin : name, shot.camera});
      }
    } else {
      for (const std::string& name : truth_.pictures->names()) take({name});
    }
    if (views.empty())
      fail("{} and {}: no view has a picture in both", truth_.path.string(), judged_.path.string());
    if (missing > 0) warn(skipped_sentence(missing));
    return views;
  }

  Image read(const File& file) {
    return read_photograph(*file, options_.frame.background.value_or(glm::vec3(0)), 1, pool_);
  }

  static Image draw(Side& side, const Camera& camera) {
    const Camera placed = camera.placed(side.session.scene->cloud.origin);
    return side.session.renderer->render(placed, side.session.settings).color;
  }

  // A camera in the size of the other side's picture.
  static Camera fitted(const Camera& camera, const Image& picture, const File& file) {
    require_same_shape(picture, *file, {camera.width, camera.height});
    return camera.resized(picture.width, picture.height);
  }

  PicturePair pair_of(const JudgedView& view) {
    Image truth, judged;
    if (view.truth) truth = read(view.truth);
    if (view.judged) judged = read(view.judged);
    if (!view.truth)
      truth = draw(truth_, view.judged ? fitted(*view.camera, judged, view.judged) : *view.camera);
    if (!view.judged)
      judged = draw(judged_, view.truth ? fitted(*view.camera, truth, view.truth) : *view.camera);
    if (truth.width != judged.width || truth.height != judged.height)
      fail(
          "{}: {} has {} x {} pixels and {} has {} x {}: only pictures of one size can be "
          "compared",
          view.name, result_.truth, truth.width, truth.height, result_.judged, judged.width,
          judged.height);
    return judge_pictures(view.name, std::move(truth), std::move(judged), pool_);
  }

  void judge(const std::vector<JudgedView>& views) {
    ProgressBar bar("judging");
    const Progress progress = bar.progress();
    for (std::size_t i = 0; i < views.size(); ++i) {
      const PicturePair pair = pair_of(views[i]);
      result_.views.push_back(pair.quality);
      if (draws_sheet()) keep_worst(sheet_row(pair, kSheetWidth, pool_));
      progress.update(static_cast<float>(i + 1) / static_cast<float>(views.size()));
    }
  }

  bool draws_sheet() const { return options_.sheet || options_.out_dir; }

  // The rows of the sheet, worst first.
  void keep_worst(SheetRow row) {
    const auto place = std::ranges::upper_bound(
        sheet_, row, [](const auto& a, const auto& b) { return a.quality.psnr < b.quality.psnr; });
    sheet_.insert(place, std::move(row));
    if (sheet_.size() > static_cast<std::size_t>(options_.sheet_views)) sheet_.pop_back();
  }

  void report(std::size_t views) {
    result_.method = {
        {"views", views},
        {"psnr",
         "-10 log10(mean squared error of all RGB values), peak 1; the mean is over the "
         "views that differ"},
        {"ssim", ssim_method(SsimBorder::zeros)},
        {"flip", "LDR-FLIP at 67.02 pixels per degree, mean over pixels"}};
    if (const Side* side = scene()) {
      result_.environment = environment_json(side->session);
      alterations_of(side->session).add_to(result_.environment);
    }
    const bool to_stdout = options_.csv == "-" || options_.json == "-";
    fmt::print(to_stdout ? stderr : stdout, "{}", format_judgement_table(result_));
    if (options_.csv) write_text(*options_.csv, format_judgement_csv(result_));
    if (options_.json) write_text(*options_.json, format_judgement_json(result_));
    if (options_.sheet) {
      write_image(sheet(), *options_.sheet);
      fmt::print(stderr, "wrote {}\n", options_.sheet->string());
    }
    if (!options_.out_dir) return;
    replace_folder(*options_.out_dir, [&](const std::filesystem::path& hidden) {
      write_judgement(result_, hidden);
      write_image(sheet(), hidden / "sheet.png");
    });
    fmt::print(stderr, "wrote {}\n", options_.out_dir->string());
  }

  Image sheet() const {
    const double scale = options_.flip_max > 0 ? options_.flip_max : flip_scale(sheet_);
    std::string truth = scene_name(truth_.path), judged = scene_name(judged_.path);
    if (truth == judged) {
      truth = truth_.path.filename().string();
      judged = judged_.path.filename().string();
    }
    return draw_contact_sheet(sheet_, truth, judged, scale);
  }

  const JudgeOptions& options_;
  Side truth_, judged_;
  ThreadPool pool_;
  Judgement result_;
  std::vector<SheetRow> sheet_;
};

}  // namespace

void declare_judge_options(Options& options, JudgeOptions& judge) {
  options.text("--csv", "FILE", judge.csv, "one row per view, the worst first; - = stdout",
               {"-", "judge.csv"});
  options.text("--json", "FILE", judge.json, "views, means and method; - = stdout",
               {"-", "judge.json"});
  options.text("--out-dir", "DIR", judge.out_dir, "folder of judge.csv, judge.json and sheet.png",
               {"out"});
  options.integer("--sheet-views", "N", 1, 100, judge.sheet_views,
                  "the sheet shows the N worst views (default: 8)");
  options.real("--flip-max", "F", 0, 1, judge.flip_max,
               "visible difference at the end of the sheet's colour bar; 0: the least of 0.05, "
               "0.1, 0.2, 0.5 and 1 that fits (default: 0)");
}

void run_judging(const JudgeOptions& options) {
  if (options.csv == "-" && options.json == "-")
    fail(ErrorKind::usage, "--csv and --json cannot both go to stdout");
  if (options.frame.modes.size() > 1)
    fail(ErrorKind::usage, "--cull: pictures are judged in one mode: choose one");
  for (const std::filesystem::path& side : {options.frame.scene, options.judged}) {
    FrameOptions frame = options.frame;
    frame.scene = side;
    if (holds_scene(side)) note_inputs(frame);
  }
  check_report(options.out_dir, kJudgeFiles);
  check_targets({options.csv, options.json, options.sheet});
  if (options.sheet) check_picture_name(*options.sheet);
  Judging(options).run();
}

CommandAction judge_command(Options& options) {
  const auto judge = std::make_shared<JudgeOptions>();
  options.positional("TRUTH", judge->frame.scene, "folder of pictures, splat file or model folder",
                     {"images", "scene.ply"});
  options.positional("JUDGED", judge->judged, "folder of pictures, splat file or model folder",
                     {"scene.ply", "images"});
  declare_common_options(options, judge->frame);
  declare_camera_choice(options, judge->cameras);
  declare_judge_options(options, *judge);
  options.overwrite();
  options.example("quadsplat judge photographs/ renders/ --out-dir out",
                  "pictures with equal names, the worst first");
  options.example("quadsplat judge renders/ plush.spz",
                  "another program's pictures, named as the cameras, against this one's");
  return [judge](Arguments) {
    run_judging(*judge);
    return kExitOk;
  };
}

}  // namespace qs
