// SPDX-License-Identifier: MIT
//
// This project's renderers as a plugin: in turns with themselves they must draw the same pictures
// in the same time. QS_OWN_BACKEND is the backend; the environment variable QS_OWN_MODE names a
// culling mode, quadbox without it.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <memory>

#include "quadsplat/plugin.h"
#include "raster/renderer.h"

namespace qs {
namespace {

struct Own {
  Own(int threads, CullMode culling) : pool(threads), mode(culling) {}

  ThreadPool pool;
  std::unique_ptr<Renderer> renderer;
  CullMode mode;
};

GaussianCloud cloud_of(const QsScene& scene) {
  GaussianCloud cloud;
  cloud.resize(scene.count, scene.sh_degree);
  const auto coefficients = static_cast<std::size_t>(sh_coefficient_count(scene.sh_degree));
  const auto triple = [](const float* from, std::size_t i) {
    return glm::vec3(from[3 * i], from[3 * i + 1], from[3 * i + 2]);
  };
  for (std::size_t i = 0; i < scene.count; ++i) {
    const float* const q = scene.rotations + 4 * i;
    cloud.positions[i] = triple(scene.positions, i);
    cloud.log_scales[i] = triple(scene.log_scales, i);
    cloud.rotations[i] = glm::quat(q[0], q[1], q[2], q[3]);
    cloud.opacity_logits[i] = scene.opacity_logits[i];
    for (std::size_t k = 0; k < coefficients; ++k)
      cloud.sh[i * coefficients + k] = triple(scene.sh, i * coefficients + k);
  }
  return cloud;
}

int32_t refuse(char* message, const char* why) {
  std::snprintf(message, QS_MESSAGE_BYTES, "%s", why);
  return 1;
}

int32_t open_scene(const QsScene* scene, void** renderer, char* message) try {
  const char* const name = std::getenv("QS_OWN_MODE");
  const CullMode mode = find_culler(name == nullptr ? "quadbox" : name);
  if (mode <= 0) return refuse(message, "QS_OWN_MODE names no mode");
  auto own = std::make_unique<Own>(scene->threads, mode);
  own->renderer = make_renderer(Backend::QS_OWN_BACKEND, own->pool, scene->device);
  own->renderer->upload(cloud_of(*scene), {});
  *renderer = own.release();
  return 0;
} catch (const std::exception& error) {
  return refuse(message, error.what());
}

int32_t render(void* renderer, const QsView* view, QsFrame* frame, char* message) try {
  Camera camera;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column)
      camera.view_from_world[column][row] = view->view_from_world[4 * row + column];
  }
  camera.focal_px = {view->focal_px[0], view->focal_px[1]};
  camera.center_px = {view->center_px[0], view->center_px[1]};
  camera.width = view->width;
  camera.height = view->height;
  camera.near_depth = view->near_depth;
  Own& own = *static_cast<Own*>(renderer);
  RenderSettings settings;
  settings.mode = own.mode;
  settings.sh_degree = view->sh_degree;
  settings.splat_scale = view->splat_scale;
  settings.background = {view->background[0], view->background[1], view->background[2]};
  settings.antialiased = view->antialiased != 0;
  settings.dilation = view->dilation_px2;
  Outputs outputs;
  outputs.stage_times = frame->mark_stages != 0;
  const Frame& drawn = own.renderer->render(camera, settings, outputs);
  std::copy(drawn.color.values.begin(), drawn.color.values.end(), frame->image);
  frame->frame_ms = static_cast<double>(drawn.stats.frame_ms);
  for (int stage = 0; stage < kStageCount; ++stage)
    frame->stage_ms[stage] = static_cast<double>(drawn.stats.stage_ms[stage]);
  frame->pairs = drawn.stats.tile_pairs;
  frame->visible = drawn.stats.visible;
  return 0;
} catch (const std::exception& error) {
  return refuse(message, error.what());
}

void close_scene(void* renderer) { delete static_cast<Own*>(renderer); }

}  // namespace
}  // namespace qs

#define QS_TEXT(word) #word
#define QS_OWN_NAME(backend) "own-" QS_TEXT(backend)

const QsPlugin* qs_plugin() {
  static const QsPlugin plugin = {QS_PLUGIN_VERSION,
                                  QS_MEMORY_HOST,
                                  QS_IMAGE_HWC,
                                  0,
                                  QS_OWN_NAME(QS_OWN_BACKEND),
                                  "quadsplat's own renderer as a plugin",
                                  qs::open_scene,
                                  qs::render,
                                  qs::close_scene};
  return &plugin;
}
