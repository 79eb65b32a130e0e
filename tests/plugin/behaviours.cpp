// SPDX-License-Identifier: MIT
//
// Plugins that have one defect each, or draw a picture that a test can compute. The name of the
// library's file chooses the behaviour, so copies of one library are different plugins.
//   draws, draws_planes, draws_on_device   a ramp: red x, green y, blue the first Gaussian's
//   opacity
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <thread>

#include <dlfcn.h>

#include "quadsplat/plugin.h"

namespace {

// The file's name without folder and extension.
std::string behaviour() {
  Dl_info info = {};
  dladdr(reinterpret_cast<const void*>(&qs_plugin), &info);
  std::string name = info.dli_fname;
  name = name.substr(name.rfind('/') + 1);
  return name.substr(0, name.find('.'));
}

bool is(const char* name) { return behaviour() == name; }

int32_t open_scene(const QsScene* scene, void** renderer, char* message) {
  if (is("crashes_at_open")) std::abort();
  if (is("refuses_to_open")) {
    std::snprintf(message, QS_MESSAGE_BYTES, "%d Gaussians\nare too many",
                  static_cast<int>(scene->count));
    return 7;
  }
  if (is("throws_at_open")) throw std::string("no standard exception");
  *renderer = new QsScene(*scene);
  return 0;
}

int32_t render(void* renderer, const QsView* view, QsFrame* frame, char* message) {
  if (is("crashes_in_render") || (is("crashes_on_wide_views") && view->width > 64)) std::abort();
  if (is("ends_its_process")) std::_Exit(3);
  if (is("never_answers")) {
    for (;;) std::this_thread::sleep_for(std::chrono::hours(1));
  }
  if (is("refuses_to_render")) {
    std::snprintf(message, QS_MESSAGE_BYTES, "%s", "there is no such view");
    return -1;
  }
  if (is("returns_nonsense_as_time")) frame->frame_ms = std::nan("");
  if (is("returns_too_long_a_time")) frame->frame_ms = 1e8;
  if (is("writes_nothing")) return 0;
  static int frames = 0;
  ++frames;
  const auto& scene = *static_cast<const QsScene*>(renderer);
  const bool planes = is("draws_planes");
  for (int y = 0; y < view->height; ++y) {
    for (int x = 0; x < view->width; ++x) {
      const float color[] = {static_cast<float>(x) / 256, static_cast<float>(y) / 256,
                             scene.opacities[0]};
      for (int channel = 0; channel < 3; ++channel) {
        const int at = planes ? (channel * view->height + y) * view->width + x
                              : (y * view->width + x) * 3 + channel;
        frame->image[at] = color[channel];
      }
    }
  }
  if (is("draws_another_picture_each_time")) frame->image[0] = static_cast<float>(frames % 7);
  if (is("returns_nan")) frame->image[3 * (2 * view->width + 5)] = std::nanf("");
  std::puts("this is not part of a report");
  return 0;
}

void close_scene(void* renderer) {
  if (is("crashes_at_close")) std::abort();
  delete static_cast<QsScene*>(renderer);
}

}  // namespace

const QsPlugin* qs_plugin() {
  static const std::string name = is("has_no_name") ? "" : behaviour();
  static QsPlugin plugin = {QS_PLUGIN_VERSION, QS_MEMORY_HOST, QS_IMAGE_HWC, 0,          nullptr,
                            "a test",          open_scene,     render,       close_scene};
  plugin.name = name.c_str();
  if (is("has_another_version")) plugin.version = QS_PLUGIN_VERSION + 1;
  if (is("draws_planes")) plugin.image_layout = QS_IMAGE_CHW;
  if (is("draws_on_device")) plugin.memory = QS_MEMORY_CUDA;
  return &plugin;
}
