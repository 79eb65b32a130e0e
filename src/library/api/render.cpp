// SPDX-License-Identifier: MIT
//
// Pictures and counts of views.
#include <utility>

#include "library/api/scene.h"
#include "library/check/arrays.h"
#include "library/check/gpu_arrays.h"
#include "library/check/stage_arguments.h"
#include "library/check/structs.h"

using namespace qs::library;

namespace {

/// The memory of the maps that may be on a GPU. The first of them decides it.
Place place_of_maps(const QsPicture& picture) {
  const std::pair<const char*, const QsArray&> maps[] = {{"color", picture.color},
                                                         {"alpha", picture.alpha},
                                                         {"depth", picture.depth},
                                                         {"median_depth", picture.median_depth}};
  for (const auto& [name, map] : maps)
    if (!is_absent(map)) return {map.memory, map.device, name};
  return {};
}

/// Throws Error(usage) unless every requested array fits the view.
void check_picture(const QsPicture& picture, const Place& of_maps, const Camera& camera,
                   const TileGrid& grid, const Where& where) {
  if (picture.reserved != 0) refuse(where / "reserved", "is not 0");
  const std::int64_t width = camera.width, height = camera.height;
  const ArrayChecks colors{where, kColors, Access::writes, of_maps};
  colors.optional(picture.color, "color", {height, width, 3});
  colors.optional(picture.alpha, "alpha", {height, width});
  const ArrayChecks depths{where, kFloat32, Access::writes, of_maps};
  depths.optional(picture.depth, "depth", {height, width});
  depths.optional(picture.median_depth, "median_depth", {height, width});
  const ArrayChecks numbers{where, kIntegers, Access::writes};
  numbers.optional(picture.evaluated, "evaluated", {height, width});
  numbers.optional(picture.pairs, "pairs", {grid.rows, grid.columns});
  numbers.optional(picture.used, "used", {grid.rows, grid.columns});
  if (picture.counts != nullptr) checked_size(picture.counts, where / "counts");
}

Outputs outputs_of(const QsPicture& picture) {
  return {.color = !is_absent(picture.color),
          .pairs = !is_absent(picture.pairs),
          .evaluated = !is_absent(picture.evaluated),
          .used = !is_absent(picture.used),
          .depth = !is_absent(picture.alpha) || !is_absent(picture.depth) ||
                   !is_absent(picture.median_depth)};
}

QsCounts counts_of(const Frame& frame) {
  const RenderStats& stats = frame.stats;
  QsCounts counts{};
  counts.pipeline = stats.pipeline == Pipeline::fast ? QS_PIPELINE_FAST : QS_PIPELINE_CLASSIC;
  counts.tile_columns = frame.grid.columns;
  counts.tile_rows = frame.grid.rows;
  counts.tile_px = frame.grid.tile_px;
  counts.threads = stats.threads;
  counts.gaussians = stats.gaussians;
  counts.visible = stats.visible;
  counts.tile_pairs = stats.tile_pairs;
  counts.max_pairs_in_a_tile = stats.max_pairs_in_a_tile;
  counts.sort_bytes = stats.sort_bytes;
  counts.used_pairs = stats.used_pairs.value_or(0);
  counts.frame_ms = static_cast<double>(stats.frame_ms);
  for (int stage = 0; stage < kStageCount; ++stage)
    counts.stage_ms[stage] = static_cast<double>(stats.stage_ms[stage]);
  return counts;
}

/// A view of a call, checked.
struct CheckedView {
  DrawnCamera drawn;
  QsPicture picture;
  Place of_maps;
  Where where;
};

void store_frame(const Frame& frame, const CheckedView& view, const Use& use) {
  const auto& [drawn, picture, of_maps, where] = view;
  const Camera& camera = drawn.camera;
  const auto save = [&](const QsArray& array, const auto& values, int rows, int columns,
                        int channels = 1) {
    if (!is_absent(array)) store(array, use.pool(), values.data(), rows, columns, channels);
  };
  if (of_maps.is_gpu()) {
    store_on_gpu(frame.on_device, picture, camera, use);
  } else {
    save(picture.color, frame.color.values, camera.height, camera.width, 3);
    save(picture.alpha, frame.depth.alpha, camera.height, camera.width);
    save(picture.depth, frame.depth.expected, camera.height, camera.width);
    save(picture.median_depth, frame.depth.median, camera.height, camera.width);
  }
  save(picture.evaluated, frame.evaluated, camera.height, camera.width);
  save(picture.pairs, frame.pairs, frame.grid.rows, frame.grid.columns);
  save(picture.used, frame.used, frame.grid.rows, frame.grid.columns);
  if (picture.counts != nullptr) write_struct(counts_of(frame), picture.counts, where / "counts");
}

CheckedView view_at(const QsCamera* cameras, const QsPicture* pictures, std::uint64_t number,
                    const RenderSettings& settings) {
  const auto index = static_cast<std::int64_t>(number);
  const Where of_cameras{"qs_render", "cameras", index};
  const Where of_pictures{"qs_render", "pictures", index};
  CheckedView view{drawn_camera_of(element(cameras, number, of_cameras), of_cameras),
                   read_struct(element(pictures, number, of_pictures), of_pictures),
                   {},
                   of_pictures};
  view.of_maps = place_of_maps(view.picture);
  const Camera& camera = view.drawn.camera;
  check_picture(view.picture, view.of_maps, camera,
                TileGrid::of_image(camera.width, camera.height, settings.tile_px), of_pictures);
  if (view.drawn.lens && !(is_absent(view.picture.evaluated) && is_absent(view.picture.pairs) &&
                           is_absent(view.picture.used)))
    refuse(of_pictures,
           "a camera with the model {} is drawn by several pictures, so evaluated, pairs and used "
           "must be absent",
           view.drawn.lens->model->name);
  if (settings.mode == kReferenceMode &&
      !(is_absent(view.picture.pairs) && is_absent(view.picture.used)))
    refuse(of_pictures, "mode reference has no tile lists, so pairs and used must be absent");
  return view;
}

}  // namespace

int32_t qs_render(QsSceneHandle* scene, const QsCamera* cameras, uint64_t views,
                  const QsSettings* settings, const QsPicture* pictures, char* message) {
  return library::call(__func__, message, "scene", scene, [&](const char* function) {
    RenderSettings chosen = settings_of(settings, {function, "settings"});
    const Use use(scene->scene.context(), {function, "scene"});
    for (std::uint64_t i = 0; i < views; ++i) {
      const CheckedView view = view_at(cameras, pictures, i, chosen);
      const Place& place = view.of_maps;
      if (place.is_gpu()) use.require_gpu(place.device, view.where / place.decided_by);
    }
    if (views == 0) return;
    Renderer& renderer = scene->scene.renderer(use.stop());
    for (std::uint64_t i = 0; i < views; ++i) {
      const CheckedView view = view_at(cameras, pictures, i, chosen);
      chosen.lens = view.drawn.view();
      const Target target = view.of_maps.is_gpu() ? Target(DeviceImage{}) : Target(HostImage{});
      store_frame(
          renderer.render(view.drawn.camera, chosen, outputs_of(view.picture), target, use.stop()),
          view, use);
    }
  });
}
