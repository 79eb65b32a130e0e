// SPDX-License-Identifier: MIT
#include "app/support/plugin_in_process.h"

#include <stdexcept>

#include <dlfcn.h>

#include "app/plugin/scene_arrays.h"

namespace qs::test {
namespace {

void require(bool holds, const char* what) {
  if (!holds) throw std::runtime_error(what);
}

}  // namespace

PluginInProcess::PluginInProcess(const std::filesystem::path& library) {
  void* const handle = dlopen(library.c_str(), RTLD_NOW | RTLD_LOCAL);
  require(handle != nullptr, "the plugin cannot be loaded");
  const auto find = reinterpret_cast<const QsPlugin* (*)()>(dlsym(handle, "qs_plugin"));
  require(find != nullptr, "it is no plugin");
  plugin_ = find();
  require(plugin_->memory == QS_MEMORY_HOST && plugin_->image_layout == QS_IMAGE_HWC,
          "it draws elsewhere or in another order");
}

Image PluginInProcess::draw(const GaussianCloud& cloud, const Camera& camera,
                            const RenderSettings& settings) const {
  ThreadPool pool(1);
  SharedMemory memory;
  QsScene scene = fill_scene(cloud, pool, memory);
  scene.threads = 1;
  point_into(memory.mapping(), scene);
  char message[QS_MESSAGE_BYTES] = {};
  void* renderer = nullptr;
  require(plugin_->open(&scene, &renderer, message) == 0, message);
  Image image(camera.width, camera.height, 3);
  QsFrame frame = {};
  frame.image = image.values.data();
  const QsView view = view_of(camera, settings, cloud.sh_degree, cloud.antialiased);
  const bool drawn = plugin_->render(renderer, &view, &frame, message) == 0;
  plugin_->close(renderer);
  require(drawn, message);
  return image;
}

}  // namespace qs::test
