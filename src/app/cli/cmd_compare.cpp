// SPDX-License-Identifier: MIT
//
// quadsplat compare: one view in several modes, pipelines and backends, side by side; or two scenes
// on all cameras.
#include <cstdio>
#include <memory>

#include "app/cli/camera_choice.h"
#include "app/cli/command.h"
#include "app/cli/judging.h"
#include "app/inspect/comparison_sheet.h"
#include "app/inspect/reference_check.h"
#include "app/measure/scene_facts.h"
#include "app/session/alterations.h"
#include "app/session/shot.h"
#include "base/fail.h"
#include "base/progress_bar.h"
#include "io/bytes/replace_file.h"
#include "io/picture/image_file.h"
#include "options/suggestion.h"

namespace qs {
namespace {

constexpr int kTolerance = 2;  // difference of 8-bit values above which the oracle names a pixel

// The result of two scenes has the options of judging; `sheet` is --output.
struct CompareCommand : JudgeOptions {
  std::vector<std::filesystem::path> others;  // a second scene
  std::optional<PixelBox> crop;
  CullMode against = kReferenceMode;
  int amplification = 16;
  bool everywhere = false;
  bool exact_color = false;
};

CullMode parse_mode(const std::string& name, const std::string& text) {
  const CullMode mode = find_culler(text);
  if (mode < 0)
    fail(ErrorKind::usage, "{}: '{}' is no mode, see --cull{}", name, text,
         suggestion(text, mode_list()));
  return mode;
}

std::optional<PixelBox> parse_crop(const std::string&, const std::string& text) {
  if (text == "auto") return std::nullopt;
  const PixelRect part = parse_part(text, "neither X,Y,W,H nor auto");
  return PixelBox{part.x, part.y, part.x + part.width, part.y + part.height};
}

class Compare {
 public:
  explicit Compare(const CompareCommand& command)
      : command_(command), session_(open_session(command.frame)) {
    shot_ = choose_shots(command.cameras, command.frame, session_).front();
    if (command.crop) require_part_inside(rect_of(*command.crop), shot_.camera);
  }

  int run() {
    ViewComparison view;
    view.truth_name = mode_name(command_.against);
    const Progress progress = bar_.progress();
    const std::vector<CullMode>& modes = command_.frame.modes;
    const float drawn = command_.against == kReferenceMode ? 0.5f : 0;  // the reference takes long
    view.truth = truth(part_of(progress, 0, drawn));
    for (std::size_t i = 0; i < modes.size(); ++i) {
      add_variants(modes[i], view);
      progress.update(drawn +
                      (1 - drawn) * static_cast<float>(i + 1) / static_cast<float>(modes.size()));
    }
    bar_.hide();
    view.crop = command_.crop.value_or(most_different_crop(
        view.truth, view.variants, default_crop_size(shot_.camera.width, shot_.camera.height)));
    fmt::print("{}, {} x {}{}, {}", shot_.origin, shot_.camera.width, shot_.camera.height,
               altered_clause(session_), format_comparison(view));
    if (!command_.sheet) return kExitOk;
    write_image(draw_comparison(view, command_.amplification,
                                picture_title(session_.scene->path, shot_.origin), *session_.pool),
                *command_.sheet, frame_metadata(session_, shot_.camera, command_.against, {}));
    fmt::print(stderr, "wrote {}\n", command_.sheet->string());
    return kExitOk;
  }

 private:
  Image truth(const Progress& progress) {
    if (command_.against == kReferenceMode)
      return reference_image(session_, shot_.camera, progress);
    RenderSettings settings = session_.settings;
    settings.mode = command_.against;
    return session_.renderer->render(shot_.camera, settings).color;
  }

  void add_variants(CullMode mode, ViewComparison& view) {
    RenderSettings settings = session_.settings;
    settings.mode = mode;
    if (!command_.everywhere) return add_one(session_.backend, settings, mode_name(mode), view);
    for (const Backend backend : available_backends()) {
      if (backend != Backend::cpu && mode == kReferenceMode) continue;
      for (const Pipeline pipeline : pipelines_of(backend)) {
        settings.pipeline = pipeline;
        add_one(backend, settings, full_name({mode, pipeline, backend}), view);
      }
    }
  }

  void add_one(Backend backend, const RenderSettings& settings, const std::string& name,
               ViewComparison& view) {
    Renderer& renderer = renderer_on(session_, backend);
    view.variants.push_back(draw_variant(renderer, shot_.camera, settings, name, view.truth));
    ViewVariant& variant = view.variants.back();
    const bool judged = command_.against == kReferenceMode && settings.mode != kReferenceMode;
    if (!judged || variant.largest <= kTolerance) return;
    Outputs outputs{.trace = true};
    const Frame& frame = renderer.render(shot_.camera, settings, outputs);
    const ReferenceCheck check =
        check_against_reference(renderer_on(session_, Backend::cpu), {shot_.camera, settings},
                                frame, view.truth, kTolerance, {});
    variant.remark = check_sentence(check, kTolerance);
  }

  const CompareCommand& command_;
  Session session_;
  Shot shot_;
  ProgressBar bar_{"comparing"};
};

// The first scene is the truth.
int run_two_scenes(CompareCommand& command) {
  check_rules("compare",
              {{command.others.size() > 1,
                fmt::format("it compares two scenes, not {}", 1 + command.others.size())},
               {command.crop || command.everywhere || command.against != kReferenceMode,
                "--part, --everywhere and --against compare modes of one scene, not two scenes"}});
  if (command.exact_color) command.frame.network = NetworkUse::if_any;
  command.judged = command.others.front();
  if (command.frame.modes.empty()) command.frame.modes = {default_mode()};
  run_judging(command);
  return kExitOk;
}

int run_one_scene(CompareCommand& command) {
  if (command.frame.modes.empty()) command.frame.modes = all_modes();
  if (command.exact_color) command.frame.network = NetworkUse::always;
  check_rules("compare", {{command.csv || command.json || command.out_dir,
                           "--csv, --json and --out-dir need a second scene"},
                          {command.cameras.several(), "it shows one view: choose one camera"}});
  note_inputs(command.frame);
  check_targets({command.sheet});
  if (command.sheet) check_picture_name(*command.sheet);
  return Compare(command).run();
}

}  // namespace

CommandAction compare_command(Options& options) {
  const auto command = std::make_shared<CompareCommand>();
  command->frame.modes = {};  // the default depends on the number of scenes
  declare_frame_options(options, command->frame);
  options.positionals("OTHER", command->others, 0,
                      "a second scene: both are drawn in one mode, and PSNR, SSIM and FLIP of "
                      "every view are listed",
                      {"model"});
  declare_camera_choice(options, command->cameras);
  options.converted(
      "--against", "NAME", command->against, parse_mode,
      "mode to compare with (default: reference, the fp64 reference, which takes seconds)",
      {"reference", "exact"});
  options.converted("--part", "X,Y,W,H", command->crop, parse_crop,
                    "part to show in pixels, or auto: where the modes differ most (default: auto)",
                    {"auto", "0,0,8,8", "40,24,8,8"});
  options.integer("--amplify", "N", 1, 128, command->amplification,
                  "factor on the drawn differences (default: 16)");
  options.flag("--everywhere", command->everywhere,
               "draws every mode on every backend and pipeline that works here");
  declare_exact_color_option(options, command->exact_color,
                             "every picture of a scene with a network");
  options.text("--output", "FILE", command->sheet, "picture of all crops and differences",
               {"sheet.png"});
  declare_judge_options(options, *command);
  options.overwrite();
  options.example("quadsplat compare plush.ply plush.spz --output sheet.png",
                  "what compression costs, on all cameras of the first scene");
  options.example("quadsplat compare plush.spz --cull 3dgs,dualbox,quadbox --output compare.png",
                  "three modes against the fp64 reference, where they differ most");
  options.example("quadsplat compare plush.spz --cull quadbox --everywhere --against quadbox",
                  "do all backends and pipelines draw the same?");
  return [command](Arguments) {
    return command->others.empty() ? run_one_scene(*command) : run_two_scenes(*command);
  };
}

}  // namespace qs
