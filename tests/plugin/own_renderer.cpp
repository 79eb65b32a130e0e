// SPDX-License-Identifier: MIT
//
// This project's renderers as plugins with scene and image in host memory: measured in turns with
// the built-in renderers, they must draw the same pictures in the same time. QS_OWN_BACKEND is the
// backend.
#include <algorithm>
#include <memory>

#include "plugin/own.h"

namespace qs {
namespace {

struct Own {
  Own(int threads, int device)
      : pool(threads), renderer(make_renderer(Backend::QS_OWN_BACKEND, pool, device)) {}

  ThreadPool pool;
  RenderSettings settings = own::settings();
  std::unique_ptr<Renderer> renderer;
};

int32_t open_scene(const QsScene* scene, void** renderer, char* message) {
  return own::guarded(message, [&] {
    auto opened = std::make_unique<Own>(scene->threads, scene->device);
    opened->renderer->upload(own::cloud_of(*scene), {});
    *renderer = opened.release();
  });
}

int32_t render(void* renderer, const QsView* view, QsFrame* frame, char* message) {
  return own::guarded(message, [&] {
    Own& opened = *static_cast<Own*>(renderer);
    own::apply(*view, opened.settings);
    const Frame& drawn =
        opened.renderer->render(own::camera_of(*view), opened.settings, own::outputs_of(*frame));
    std::copy(drawn.color.values.begin(), drawn.color.values.end(), frame->image);
    own::report(drawn.stats, *frame);
  });
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
