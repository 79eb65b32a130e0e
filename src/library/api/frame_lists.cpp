// SPDX-License-Identifier: MIT
//
// The decisions of a frame: footprints, tile lists, and the pairs of every mode.
#include <algorithm>
#include <cstddef>

#include "library/api/scene.h"
#include "library/check/arrays.h"
#include "library/check/stage_arguments.h"
#include "library/check/structs.h"

using namespace qs::library;

namespace {

/// A member of every element of a vector of structs of floats, as an array.
template <class Struct>
QsArray members(const std::vector<Struct>& structs, std::size_t offset_bytes,
                std::int64_t columns) {
  static_assert(sizeof(Struct) % sizeof(float) == 0);
  const auto* bytes = reinterpret_cast<const unsigned char*>(structs.data());
  return view_of(structs.empty() ? nullptr : bytes + offset_bytes, structs.size(), QS_FLOAT32,
                 columns, sizeof(Struct) / sizeof(float));
}

template <class Value>
QsArray whole(const std::vector<Value>& values, std::uint32_t type) {
  return view_of(values.data(), values.size(), type);
}

const Frame& frame_without_picture(OpenScene& scene, const Camera& view,
                                   const RenderSettings& settings, Outputs outputs,
                                   const Use& use) {
  outputs.color = false;
  return scene.renderer(use.stop()).render(view, settings, outputs, HostImage{}, use.stop());
}

QsLists lists_of(const Frame& frame, OpenScene& scene) {
  const Trace& trace = frame.trace;
  QsLists lists{};
  lists.tile_px = frame.grid.tile_px;
  lists.tile_columns = frame.grid.columns;
  lists.tile_rows = frame.grid.rows;
  if (!scene.keeps_numbers()) {
    scene.visible = scene.numbers_of(trace.gaussians);
    scene.listed = scene.numbers_of(trace.listed);
  }
  lists.gaussians = whole(scene.keeps_numbers() ? trace.gaussians : scene.visible, QS_UINT32);
  lists.listed = whole(scene.keeps_numbers() ? trace.listed : scene.listed, QS_UINT32);
  lists.depths = whole(trace.depths, QS_FLOAT32);
  lists.tile_begin = whole(trace.tile_begin, QS_UINT64);
  lists.means_px = members(trace.footprints, offsetof(Footprint, mean_px), 2);
  lists.covariances = members(trace.footprints, offsetof(Footprint, covariance), 3);
  lists.conics = members(trace.footprints, offsetof(Footprint, conic), 3);
  lists.opacities = members(trace.splats, offsetof(Splat, opacity), 0);
  lists.colors = members(trace.splats, offsetof(Splat, color), 3);
  return lists;
}

}  // namespace

int32_t qs_lists(QsSceneHandle* scene, const QsCamera* camera, const QsSettings* settings,
                 QsLists* lists, char* message) {
  return library::call(__func__, message, "scene", scene, [&](const char* function) {
    const Camera view = camera_of(camera, {function, "camera"});
    const RenderSettings chosen = settings_of(settings, {function, "settings"});
    checked_size(lists, {function, "lists"});
    const Use use(scene->scene.context(), {function, "scene"});
    Outputs outputs{.trace = true};
    const Frame& frame = frame_without_picture(scene->scene, view, chosen, outputs, use);
    write_struct(lists_of(frame, scene->scene), lists, {function, "lists"});
  });
}

int32_t qs_count_modes(QsSceneHandle* scene, const QsCamera* camera, const QsSettings* settings,
                       QsModeCounts* counts, uint64_t capacity, uint64_t* count, char* message) {
  return library::call(__func__, message, [&](const char* function) {
    const Where of_counts{function, "counts"};
    require(scene, {function, "scene"});
    const Camera view = camera_of(camera, {function, "camera"});
    RenderSettings chosen = settings_of(settings, {function, "settings"});
    chosen.mode = default_mode();
    const auto modes = static_cast<std::uint64_t>(culler_count());
    const std::uint64_t filled = std::min(capacity, modes);
    for (std::uint64_t i = 0; i < filled; ++i)
      checked_size(element(counts, i, of_counts), of_counts);
    const Use use(scene->scene.context(), {function, "scene"});
    if (count != nullptr) *count = modes;
    if (filled == 0) return;
    Outputs outputs{.mode_pairs = true};
    const Frame& frame = frame_without_picture(scene->scene, view, chosen, outputs, use);
    for (std::uint64_t i = 0; i < filled; ++i) {
      const ModePairs& of_mode = frame.mode_pairs[i];
      const auto mode = static_cast<CullMode>(i + 1);
      write_struct(QsModeCounts{0, static_cast<std::uint32_t>(mode), mode_name(mode),
                                of_mode.tile_pairs, of_mode.visible},
                   element(counts, i, of_counts), of_counts);
    }
  });
}
