// SPDX-License-Identifier: MIT
//
// quadsplat render: views x culling modes -> pictures, a mode table, statistics, a comparison.
#include <algorithm>
#include <cstdio>
#include <memory>

#include "app/cli/camera_choice.h"
#include "app/cli/command.h"
#include "app/cli/lens_options.h"
#include "app/inspect/heatmap_frame.h"
#include "app/measure/measure.h"
#include "app/measure/paired_ratios.h"
#include "app/picture/canvas.h"
#include "app/picture/heatmap.h"
#include "app/picture/image_difference.h"
#include "app/picture/value_map.h"
#include "app/report/environment.h"
#include "app/session/alterations.h"
#include "app/session/shot.h"
#include "base/fail.h"
#include "base/path_kind.h"
#include "base/progress_bar.h"
#include "io/bytes/file_guard.h"
#include "io/bytes/replace_file.h"
#include "io/picture/image_file.h"
#include "io/picture/panorama_tag.h"

namespace qs {
namespace {

struct RenderCommand {
  FrameOptions frame;
  CameraChoice cameras;
  LensOptions lens;
  std::optional<std::filesystem::path> output, stats, reference;
  HeatOptions heat;
  Quantity quantity = Quantity::color;
  std::optional<double> depth_step;
  std::optional<PixelRect> part;  // shown enlarged in a corner
  double part_zoom = 2.5;
  std::optional<int> repeats;
  std::optional<Shard> shard;
  double reference_threshold = 0;
  bool psnr = false;
  bool exact_color = false;

  bool several_modes() const { return frame.modes.size() > 1; }
  bool measures() const { return several_modes() || repeats.has_value() || psnr; }
};

void check(const RenderCommand& command) {
  const Quantity quantity = command.quantity;
  const HeatOptions& heat = command.heat;
  require_heatmaps("render", heat, command.frame.modes);
  check_rules(
      "render",
      {{!command.output && !command.stats && !command.measures() && !command.reference,
        "--output is missing (see 'quadsplat render --help')"},
       {command.reference && (command.several_modes() || command.cameras.several()),
        "--reference compares one picture: choose one camera and one mode"},
       {command.reference_threshold > 0 && !command.reference,
        "--reference-threshold needs --reference"},
       {command.cameras.steps && !command.cameras.path,
        "--path-steps needs a --camera-path; to measure a picture several times use --repeats"},
       {command.shard && !command.cameras.several(),
        "--shard divides the pictures of --all-cameras or --camera-path: give one of them"},
       {command.shard && heat.quantity && !heat.maximum,
        "--shard with --heatmap needs --heatmap-max, so that all shards use one scale"},
       {command.part && (quantity != Quantity::color || heat.quantity || !command.output),
        "--part shows a part of the colours: it needs --output and excludes --picture and "
        "--heatmap"},
       {command.frame.settings.occlusion &&
            (command.several_modes() || heat.quantity || quantity != Quantity::color),
        "--occlusion on draws the colours of one mode: modes differ most in hidden Gaussians"},
       {heat.quantity == HeatQuantity::missed && command.lens.has_faces(), kNoLensHeatmap},
       {command.depth_step && quantity != Quantity::depth && quantity != Quantity::median_depth,
        "--depth-step needs --picture depth or median-depth"}});
  if (quantity == Quantity::color) return;
  require_colors("render", heat, quantity);
  check_rules(
      "render",
      {{command.reference.has_value(),
        fmt::format("--reference compares colours, not --picture {}", row_of(quantity).name)}});
  if (command.output) require_value_file("render", *command.output, quantity);
}

// The picture is read after others were written.
void require_reference(const std::filesystem::path& picture) {
  if (!is_there(picture)) fail("{}: no such file", picture.string());
  note_input(picture);
}

// One run of the command over its views.
class RenderRun {
 public:
  explicit RenderRun(const RenderCommand& command)
      : command_(command), session_(open_session(command.frame)) {
    set_lens(command.lens, command.frame, session_);
  }

  int all_shots() {
    const std::vector<Shot> shots = choose_shots(command_.cameras, command_.frame, session_);
    const Shard shard = command_.shard.value_or(Shard());
    for (std::size_t view = 0; view < shots.size(); ++view) {
      progress_ = step_of(bar_.progress(), view, shots.size());
      progress_.update(0);
      if (shard.takes(view)) one_shot(shots[view], view);
    }
    bar_.hide();
    if (command_.stats) write_text(*command_.stats, format_stats(session_, records_, shots.size()));
    return exit_code_;
  }

 private:
  void one_shot(const Shot& shot, std::size_t view) {
    if (command_.part) require_inset(shot.camera);
    if (command_.heat.quantity) {
      if (!scale_) scale_ = first_scale(shot.camera);
      heatmaps_.emplace(*session_.renderer, shot.camera, session_.settings, *command_.heat.quantity,
                        *session_.pool);
    }
    Outputs outputs = heatmaps_ ? heatmaps_->outputs() : outputs_for(command_.quantity);
    outputs.mode_pairs = session_.settings.occlusion;
    const int repeats =
        command_.repeats.value_or(command_.several_modes() ? int{kFewestFrames} : 1);
    MeasurePlan plan{command_.frame.modes, command_.measures() ? 1 : 0, repeats, {}, {}};
    if (command_.measures()) {
      plan.progress = part_of(progress_, command_.psnr ? kReference : 0, 0.95f);
    } else {
      session_.renderer->report_frames_to(part_of(progress_, 0, kDrawn).report);
    }
    const Image truth =
        command_.psnr ? reference_image(session_, shot.camera, part_of(progress_, 0, kReference))
                      : Image();
    const std::size_t first_record = records_.size();
    std::vector<double> psnrs;
    std::vector<ModeResult> results =
        measure_modes(*session_.renderer, shot.camera, session_.settings, outputs, plan,
                      [&](CullMode mode, const Frame& frame) {
                        records_.push_back({shot, view, {}, save(shot, mode, frame), std::nullopt});
                        if (command_.reference)
                          compare_with_reference(frame.color, records_.back());
                        if (command_.psnr) psnrs.push_back(psnr_8bit(frame.color, truth));
                      });
    for (std::size_t i = 0; i < results.size(); ++i) {
      if (command_.psnr) results[i].psnr = psnrs[i];
      if (command_.stats && session_.backend != Backend::cpu) {  // the CPU always measures stages
        mark_stages(*session_.renderer, shot.camera, session_.settings, {}, results[i]);
      }
      records_[first_record + i].result = results[i];
    }
    if (command_.measures()) {
      bar_.hide();
      fmt::print(report(), "{}, {} x {}, {} backend, median of {} frame{}{}\n{}", shot.origin,
                 shot.camera.width, shot.camera.height,
                 kBackendNames[static_cast<int>(session_.backend)], repeats,
                 repeats == 1 ? "" : "s", altered_clause(session_), format_mode_table(results));
    }
  }

  void require_inset(const Camera& camera) const {
    require_part_inside(*command_.part, camera);
    const glm::ivec2 size = enlarged_size(*command_.part, command_.part_zoom);
    if (size.x > camera.width || size.y > camera.height)
      fail(ErrorKind::usage,
           "--part: enlarged {} times it is {} x {}, but the picture is {} x {}: give a smaller "
           "--part-zoom",
           command_.part_zoom, size.x, size.y, camera.width, camera.height);
  }

  Scale first_scale(const Camera& camera) {
    if (command_.heat.maximum)
      return exact_scale(static_cast<std::uint32_t>(*command_.heat.maximum));
    RenderSettings settings = session_.settings;
    settings.mode = kScaleMode;
    return scale_of_view(*session_.renderer, camera, settings, *command_.heat.quantity,
                         *session_.pool);
  }

  // Writes the frame's picture. Returns its path, or "" without --output.
  std::string save(const Shot& shot, CullMode mode, const Frame& frame) {
    if (!command_.output) return {};
    const char* name = mode_name(mode);
    std::filesystem::path path = *command_.output;
    if (command_.cameras.several()) path = with_shot(path, shot);
    if (command_.several_modes()) path = with_word(path, name);
    ImageMetadata metadata = frame_metadata(session_, shot.camera, mode, frame.stats);
    const Progress progress = !command_.measures() ? part_of(progress_, kDrawn, 1) : Progress();
    if (command_.lens.is_panorama() && !command_.lens.stereo)
      metadata[kXmpText] =
          panorama_xmp(shot.camera.width, shot.camera.height, command_.lens.panorama_degrees());
    std::string values;  // the unit of the file's values instead of colours
    if (command_.quantity != Quantity::color) {
      const ValueMap map = map_of(frame, command_.quantity, shot.camera.width, shot.camera.height);
      values =
          fmt::format(", {}: {}", row_of(command_.quantity).name,
                      write_values(map, path, command_.depth_step, std::move(metadata), progress));
    } else if (heatmaps_) {
      const auto [map, missed] = heatmaps_->map(frame);
      if (missed) fmt::print(stderr, "{}\n", missed_sentence(*missed));
      metadata["Heatmap"] = heatmap_row(map.quantity).name;
      metadata["HeatmapTotal"] = fmt::format("{}", map.total);
      write_image(draw_heatmap(frame.color, map, *scale_, name), path, metadata);
    } else if (command_.part) {
      write_image(with_inset(frame.color, *command_.part, command_.part_zoom), path, metadata,
                  progress);
      write_image(enlarged(frame.color, *command_.part, command_.part_zoom),
                  with_word(path, "part"), metadata);
    } else {
      write_image(frame.color, path, metadata, progress);
    }
    bar_.hide();
    fmt::print(stderr, "wrote {} ({}, {}, {} x {}{})\n", path.string(), shot.origin, name,
               shot.camera.width, shot.camera.height, values + altered_clause(session_));
    return path.string();
  }

  void compare_with_reference(const Image& color, FrameRecord& record) {
    const Image reference = read_reference(*command_.reference, color.width, color.height);
    const ImageDifference difference = image_difference(color, reference);
    record.reference_psnr = difference.psnr;
    fmt::print(report(), "PSNR {} dB against {}, largest difference {} of 255\n",
               decibels(difference.psnr), command_.reference->string(), difference.largest);
    if (command_.output) {
      const std::filesystem::path path = difference_path(*command_.output);
      const int amplification = amplification_for(difference.largest);
      write_image(amplified_difference(color, reference, box_of(color), amplification), path);
      fmt::print(stderr, "wrote {} (differences amplified {} times)\n", path.string(),
                 amplification);
    }
    if (difference.psnr < command_.reference_threshold) {
      warn(fmt::format("the PSNR of {} dB is below the threshold of {} dB",
                       decibels(difference.psnr), command_.reference_threshold));
      exit_code_ = kExitComparison;
    }
  }

  // The stream for tables: stdout, unless --stats writes JSON to it.
  std::FILE* report() const { return command_.stats == "-" ? stderr : stdout; }

  // Shares of a picture's progress: of the reference that --psnr needs, and of drawing a large
  // picture before it is encoded.
  static constexpr float kReference = 0.5f, kDrawn = 0.3f;

  const RenderCommand& command_;
  Session session_;
  ProgressBar bar_{"rendering"};
  Progress progress_;                     // progress of the current view
  std::optional<HeatmapMaker> heatmaps_;  // maker for the current view
  std::optional<Scale> scale_;  // scale of the first view; all heat maps of a run share it
  std::vector<FrameRecord> records_;
  int exit_code_ = kExitOk;
};

}  // namespace

CommandAction render_command(Options& options) {
  const auto command = std::make_shared<RenderCommand>();
  declare_frame_options(options, command->frame);
  declare_level_options(options, command->frame.levels);
  declare_camera_choice(options, command->cameras);
  declare_lens_options(options, command->lens);
  options.text("--output", "FILE", command->output,
               "picture file OUT: .png, .ppm, .pfm, .npy, .exr, .jpg, ...; several pictures are "
               "OUT_NUMBER_NAME_MODE",
               {"out.png", "out.pfm"});
  declare_quantity_option(
      options, command->quantity,
      "what the picture holds (default: color); alpha and depths go to .npy, .exr, .pfm, .tif or "
      "16-bit .png; depth is in units of the scene");
  options.real("--depth-step", "UNITS", 1e-12, 1e12, command->depth_step,
               "units per step of a .png of depths (default: the least that holds the picture)",
               {"0.001", "0.5"});
  declare_heatmap_options(options, command->heat,
                          "fits 3dgs in the first view, so that all modes share it");
  options.converted(
      "--part", "X,Y,W,H", command->part,
      [](const auto&, const std::string& text) { return parse_part(text, "not X,Y,W,H"); },
      "shows this part of the picture enlarged in its farthest corner, as papers show "
      "details, and writes it alone as OUT_part",
      {"0,0,8,8"});
  options.real("--part-zoom", "X", 1, 64, command->part_zoom,
               "times that --part is enlarged (default: 2.5)");
  options.text("--stats", "FILE", command->stats,
               "writes the statistics of the frames as JSON; - = stdout", {"stats.json", "-"});
  options.integer("--repeats", "N", 1, 100000, command->repeats,
                  fmt::format("measured frames per picture, after one warm-up frame (default: 1, "
                              "or {} with several modes)",
                              kFewestFrames));
  options.overwrite();
  options.flag("--psnr", command->psnr,
               "adds each mode's PSNR against mode reference to the table (seconds per view)");
  declare_exact_color_option(options, command->exact_color, "every picture");
  declare_occlusion_option(options, command->frame);
  options.text("--reference", "FILE", command->reference,
               "prints the PSNR against this picture and writes OUT.difference.png",
               {"reference.pfm", "missing.png"});
  options.real("--reference-threshold", "DB", 0, 1000, command->reference_threshold,
               "ends with exit code 4 if the PSNR is lower");
  declare_shard_option(
      options, command->shard,
      "renders every N-th picture of --all-cameras or --camera-path, from the I-th");
  options.example("quadsplat render garden/ --camera-index 0 --output garden.png",
                  "one view of a trained model");
  options.example("quadsplat render plush.spz --cull all --psnr --output plush.png",
                  "compares the culling modes on one view");
  options.example("quadsplat render plush.spz --heatmap pairs --cull 3dgs --output pairs.png",
                  "where the tile pairs are");
  options.example("quadsplat render garden/ --all-cameras --picture depth --output depth.npy",
                  "the expected depth of every camera, as floats");
  options.example("quadsplat render garden/ --lens equirectangular --level --output garden.jpg",
                  "a panorama from the place of the first camera");
  options.example(
      "quadsplat render plush.spz --camera-path path.json --path-steps 240 --output f.png",
      "the pictures of a flight: f_0000.png to f_0239.png");
  return [command](Arguments) {
    if (!command->reference) use_own_lens(command->lens, command->cameras, command->frame);
    check(*command);
    if (command->reference) require_reference(*command->reference);
    note_inputs(command->frame);
    if (command->exact_color) command->frame.network = NetworkUse::always;
    check_lens("render", command->lens, command->frame);
    const bool one = !command->several_modes() && !command->cameras.several();
    check_targets({command->stats, one ? command->output : std::nullopt});
    if (command->output) check_picture_name(*command->output);
    return RenderRun(*command).all_shots();
  };
}

}  // namespace qs
