// SPDX-License-Identifier: MIT
//
// quadsplat convert: a scene in another format, with fewer SH degrees or fewer Gaussians, cropped,
// without floaters.
#include <algorithm>
#include <cstdio>
#include <memory>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "app/cli/camera_choice.h"
#include "app/cli/command.h"
#include "app/cli/shared_options.h"
#include "app/framing/scene_box.h"
#include "app/session/removal_text.h"
#include "app/session/scene_edits.h"
#include "base/fail.h"
#include "base/progress_bar.h"
#include "base/text.h"
#include "base/warn.h"
#include "io/bytes/file_guard.h"
#include "io/bytes/replace_file.h"
#include "io/cloud/cloud_memory.h"
#include "io/scene/reader.h"
#include "io/scene/writer.h"
#include "options/suggestion.h"
#include "raster/api/renderer.h"
#include "raster/scene/cloud_order.h"
#include "raster/scene/image_metrics.h"
#include "raster/scene/place.h"
#include "raster/scene/transform.h"

namespace qs {
namespace {

struct ConvertCommand {
  std::filesystem::path input, output;
  std::string axes, format;
  int degree = kMaxShDegree, largest = 0;
  std::optional<std::string> crop;  // words of parse_crop_box()
  bool drops_floaters = false;
  EditOptions edits;
  std::optional<std::string> part;  // "selected" or "rest"

  bool removes() const { return crop || drops_floaters; }
};

// The scene after the edits: the part that was asked for, scaled and level.
void edit(const ConvertCommand& command, Scene& scene, ThreadPool& pool) {
  const EditedCloud all = edited(scene, command.edits, pool);
  GaussianSet kept = all.state.rest();
  if (command.part == "selected") kept = all.state.selected;
  if (command.part == "rest") kept -= all.state.selected;
  if (kept.empty())
    fail(ErrorKind::usage, "convert: {}: no Gaussian is left", command.edits.file->string());
  keep_edited(scene, all, kept);
  if (all.transform == glm::dmat4(1)) return;
  if (const glm::dvec3 origin = std::exchange(scene.cloud.origin, {}); origin != glm::dvec3(0))
    warn(fmt::format("the positions of the turned or scaled scene count from 0, not from {}",
                     format_origin(origin)));
  const Transform transform(all.transform);
  for (std::size_t i = 0; i < scene.cloud.size(); ++i) transform.apply(scene.cloud, i);
}

GaussianCloud without_removed(const ConvertCommand& command, const GaussianCloud& cloud) {
  ProgressBar bar("looking for floaters");
  std::optional<CropBox> box;
  if (command.crop) box = parse_crop_box("--crop", *command.crop, cloud.origin);
  const Removal removal =
      find_removal(cloud, box, command.drops_floaters ? std::optional(Floaters()) : std::nullopt,
                   bar.progress());
  bar.hide();
  if (removal.staying() == 0) {
    const SceneBox all = scene_box(cloud);
    fail(ErrorKind::usage, "convert: {}: {}; the centres are in the box {}", command.input.string(),
         removal_text(removal, "would be dropped"),
         format_crop_box({all.low, all.high}, cloud.origin));
  }
  fmt::print(stderr, "{}\n", removal_text(removal, "dropped"));
  return keep_rest(cloud, removal);
}

// The different values of a column of the table of writers.
std::vector<std::string> written(const char* WriterRow::*column) {
  std::vector<std::string> words;
  for (const WriterRow& row : writers()) add_new(words, row.*column);
  return words;
}

// Throws Error(usage) if the ending of the output belongs to no format.
void check_format(const ConvertCommand& command) {
  if (find_writer(command.output, command.format) != nullptr) return;
  const std::vector<std::string> endings = written(&WriterRow::extension);
  const std::string ending = command.output.extension().string();
  fail(ErrorKind::usage, "convert: {}: {}; writable are {}{}", command.output.string(),
       ending.empty() ? "the name needs an ending that tells the format"
                      : fmt::format("cannot write '{}' files", ending),
       joined(endings, ", "), reads_ending(ending) ? "" : suggestion(ending, endings));
}

// A clause with the PSNR of the written file's picture, in a view of the whole scene. Empty for
// formats that lose nothing.
std::string loss_text(const Scene& scene, const ConvertCommand& command, const WriterRow& format,
                      ThreadPool& pool) {
  constexpr std::size_t kMostDrawn = 2'000'000;  // reading and drawing them takes seconds
  constexpr double kSamePicture = 100;           // dB
  if (format.losses == std::string_view("nothing")) return {};
  if (scene.cloud.size() > kMostDrawn) return "; compare shows its loss";
  try {
    FrameOptions frame;
    frame.size = glm::ivec2(640, 360);
    const Camera camera = overview_shot(frame, scene).camera;
    const auto renderer = make_renderer(Backend::cpu, pool);
    const auto picture = [&](GaussianCloud cloud) {
      renderer->upload(std::move(cloud), {});
      return Image(renderer->render(camera).color);
    };
    const Image before = picture(scene.cloud);
    const double loss = psnr(before, picture(read_scene(command.output, pool).cloud), pool);
    return loss > kSamePicture ? "; the same picture"
                               : fmt::format("; its picture: {:.1f} dB", loss);
  } catch (const Error&) {  // the scene cannot be drawn
    return "; its loss was not measured";
  }
}

int run(const ConvertCommand& command) {
  check_format(command);
  check_rules("convert",
              {{command.part && !command.edits.file, "--edits-part: needs --edits"},
               {command.edits.recomputes && !command.edits.file, "--recompute: needs --edits"}});
  ThreadPool pool(0);
  note_input(find_scene_file(command.input));
  check_targets({command.output});
  Scene scene = load_scene(command.input, pool, -1, command.axes);
  if (command.edits.file) edit(command, scene, pool);
  if (command.removes()) scene.cloud = without_removed(command, scene.cloud);
  scene.cloud = with_sh_degree(std::move(scene.cloud), command.degree);
  if (command.largest > 0)
    scene.cloud = keep_largest(std::move(scene.cloud), static_cast<std::size_t>(command.largest));
  const WriterRow& format = [&]() -> const WriterRow& {
    ProgressBar bar("writing");
    return write_scene(scene.cloud, command.output, pool, bar.progress(), command.format);
  }();
  if (scene.cloud.origin != glm::dvec3(0) && !format.keeps_origin)
    warn(fmt::format("{}: its positions count from {}, because the format has no doubles",
                     command.output.string(), format_origin(scene.cloud.origin)));
  if (format.loss != nullptr)
    if (const std::string loss = format.loss(scene.cloud); !loss.empty())
      warn(fmt::format("{}: {}", command.output.string(), loss));
  std::error_code error;
  const auto bytes = std::filesystem::file_size(command.output, error);
  fmt::print(stderr, "wrote {} ({} Gaussians, SH degree {}, {}{})\n", command.output.string(),
             grouped(scene.cloud.size()), std::min(scene.cloud.sh_degree, format.max_sh_degree),
             error ? "size unknown" : bytes_text(bytes), loss_text(scene, command, format, pool));
  return kExitOk;
}

}  // namespace

CommandAction convert_command(Options& options) {
  const auto command = std::make_shared<ConvertCommand>();
  const std::vector<std::string> endings = written(&WriterRow::extension);
  Options::Samples outputs = {"out.unknown"};
  for (const std::string& ending : endings) outputs.push_back("out" + ending);
  options.positional("IN", command->input, kSceneHelp, kSceneSamples);
  options.positional("OUT", command->output,
                     "file to write; its ending chooses the format: " + joined(endings, ", "),
                     outputs);
  declare_sh_degree_option(options, command->degree, "all");
  options.integer("--keep-largest", "N", 1, 2'000'000'000, command->largest,
                  "keeps the N Gaussians with the largest opacity times area (default: all)");
  options.converted(
      "--crop", "X0,Y0,Z0,X1,Y1,Z1", command->crop,
      [](const std::string& option, const std::string& words) {
        parse_crop_box(option, words);
        return words;
      },
      "keeps the Gaussians with centres in this box; x right, y down, z forward, as info "
      "prints extents",
      {"-100,-100,-100,100,100,100", "-0.5,-0.5,0,0.5,0.5,9"});
  options.flag("--drop-floaters", command->drops_floaters,
               "drops Gaussians that are very faint, very large or isolated");
  options.named("--format", written(&WriterRow::name), command->format,
                "format of the file (default: by the ending)");
  declare_axes_option(options, command->axes);
  declare_edit_options(options, command->edits);
  options.flag("--recompute", command->edits.recomputes,
               "selects with the tools of the edits in place of their lists, and says differences");
  options.choice(
      "--edits-part", {"selected", "rest"},
      [command](int chosen) { command->part = chosen == 0 ? "selected" : "rest"; },
      "with --edits: the Gaussians that are selected at the end, or those that are not");
  options.overwrite();
  options.example("quadsplat convert plush.spz plush.ply", "a file that every viewer reads");
  options.example("quadsplat convert garden/ small.spz --keep-largest 300000 --sh-degree 1",
                  "a small file of a large model");
  options.example("quadsplat convert garden/ table.ply --crop -1,-1,-1,1,0.5,1 --drop-floaters",
                  "what is in a box, without floaters");
  return [command](Arguments) { return run(*command); };
}

}  // namespace qs
