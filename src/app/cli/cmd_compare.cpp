// SPDX-License-Identifier: MIT
//
// quadsplat compare: one view in several modes, pipelines and backends, side by side.
#include <cstdio>
#include <map>

#include "app/cli/command.h"
#include "app/cli/view_choice.h"
#include "app/inspect/comparison_sheet.h"
#include "app/inspect/reference_check.h"
#include "app/inspect/variant.h"
#include "app/measure/scene_facts.h"
#include "app/session/frame_metadata.h"
#include "app/session/progress_bar.h"
#include "io/picture/image_file.h"
#include "raster/base/fail.h"

namespace qs {
namespace {

constexpr int kTolerance = 2;  // of 8-bit values, before the oracle names a pixel

struct CompareCommand {
  FrameOptions frame;
  CameraChoice cameras;
  std::optional<std::filesystem::path> output;
  std::optional<PixelBox> crop;
  CullMode against = kReferenceMode;
  int amplification = 16;
  bool everywhere = false;
};

std::optional<PixelBox> parse_crop(const std::string& text) {
  if (text == "auto") return std::nullopt;
  const std::vector<std::string> words = separated(text);
  if (words.size() != 4) fail(ErrorKind::usage, "--crop: '{}' is neither X,Y,W,H nor auto", text);
  int numbers[4];
  for (int i = 0; i < 4; ++i)
    numbers[i] =
        parse_integer("--crop", words[static_cast<std::size_t>(i)], i < 2 ? 0 : 1, 1'000'000);
  return PixelBox{numbers[0], numbers[1], numbers[0] + numbers[2], numbers[1] + numbers[3]};
}

bool parse(CompareCommand& command, Arguments arguments) {
  command.frame.modes.clear();
  Options options("compare", "draws crops and differences of modes side by side");
  declare_frame_options(options, command.frame);
  declare_camera_choice(options, command.cameras);
  options.value("--against", "NAME",
                "the mode that judges (default: reference, which takes seconds)",
                [&](const std::string& text) {
                  command.against = find_culler(text);
                  if (command.against < 0)
                    fail(ErrorKind::usage, "--against: '{}' is no mode, see --cull", text);
                });
  options.value("--crop", "X,Y,W,H",
                "part to show, or auto: where they differ most (default: auto)",
                [&](const std::string& text) { command.crop = parse_crop(text); });
  options.integer("--amplify", "N", 1, 128, command.amplification,
                  "of the differences (default: 16)");
  options.flag("--everywhere", command.everywhere,
               "every mode on every backend and pipeline that works here");
  options.text("--output", "FILE", command.output, "picture of all of them");
  options.example("quadsplat compare plush.spz --cull 3dgs,dualbox,quadbox --output compare.png",
                  "three modes against the fp64 reference, where they differ most");
  options.example("quadsplat compare plush.spz --cull quadbox --everywhere --against quadbox",
                  "do all backends and pipelines draw the same?");
  if (!options.parse(arguments)) return false;
  if (command.frame.modes.empty()) command.frame.modes = all_modes();
  if (command.cameras.several())
    fail(ErrorKind::usage, "compare: it shows one view: choose one camera");
  return true;
}

class Compare {
 public:
  explicit Compare(const CompareCommand& command)
      : command_(command), session_(open_session(command.frame)) {
    shot_ = choose_shots(command.cameras, command.frame, *session_.scene).front();
    if (command.crop &&
        (command.crop->x1 > shot_.camera.width || command.crop->y1 > shot_.camera.height)) {
      fail(ErrorKind::usage, "--crop: it ends at {},{}, but the picture is {} x {}",
           command.crop->x1, command.crop->y1, shot_.camera.width, shot_.camera.height);
    }
  }

  int run() {
    ViewComparison view;
    view.truth_name = mode_name(command_.against);
    view.truth = truth();
    for (const CullMode mode : command_.frame.modes) add_variants(mode, view);
    view.crop = command_.crop.value_or(most_different_crop(
        view.truth, view.variants, default_crop_size(shot_.camera.width, shot_.camera.height)));
    fmt::print("{}, {} x {}, {}", shot_.origin, shot_.camera.width, shot_.camera.height,
               format_comparison(view));
    if (!command_.output) return kExitOk;
    const std::string where =
        fmt::format("{} \u00b7 {}", scene_name(session_.scene->path), shot_.origin);
    write_image(draw_comparison(view, command_.amplification, where, *session_.pool),
                *command_.output,
                frame_metadata(session_.scene->path, shot_.camera, command_.against, {}));
    fmt::print(stderr, "wrote {}\n", command_.output->string());
    return kExitOk;
  }

 private:
  Renderer& renderer_on(Backend backend) {
    if (backend == session_.backend) return *session_.renderer;
    std::unique_ptr<Renderer>& other = others_[backend];
    if (!other) other = upload_scene(session_, backend);
    return *other;
  }

  Image truth() {
    const bool reference = command_.against == kReferenceMode;
    RenderSettings settings = session_.settings;
    settings.mode = command_.against;
    return renderer_on(reference ? Backend::cpu : session_.backend)
        .render(shot_.camera, settings)
        .color;
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
    view.variants.push_back(
        draw_variant(renderer_on(backend), shot_.camera, settings, name, view.truth));
    ViewVariant& variant = view.variants.back();
    const bool judged = command_.against == kReferenceMode && settings.mode != kReferenceMode;
    if (!judged || variant.largest <= kTolerance) return;
    Outputs outputs;
    outputs.trace = true;
    const Frame& frame = renderer_on(backend).render(shot_.camera, settings, outputs);
    const ReferenceCheck verdict =
        check_against_reference(renderer_on(Backend::cpu), shot_.camera, settings, frame,
                                view.truth, std::nullopt, kTolerance, {});
    variant.remark = check_sentence(verdict, kTolerance);
  }

  const CompareCommand& command_;
  Session session_;
  Shot shot_;
  std::map<Backend, std::unique_ptr<Renderer>> others_;
};

}  // namespace

int run_compare(Arguments arguments) {
  CompareCommand command;
  if (!parse(command, arguments)) return kExitOk;
  return Compare(command).run();
}

}  // namespace qs
