// SPDX-License-Identifier: MIT
#include "app/plugin/scene_arrays.h"

#include <algorithm>
#include <cerrno>
#include <cstring>

#include <fcntl.h>
#include <glm/gtc/type_ptr.hpp>
#include <glm/matrix.hpp>
#include <sys/mman.h>
#include <unistd.h>

#include "base/fail.h"
#include "raster/scene/activated_cloud.h"

namespace qs {
namespace {

[[noreturn]] void refuse(const char* what, std::size_t bytes) {
  fail(ErrorKind::device, "plugin: {} bytes of shared memory: {}: {}", bytes, what,
       std::strerror(errno));
}

constexpr std::size_t kAlignment = 64;  // alignment of arrays, which plugin.h promises

std::size_t bytes_of(const QsScene& scene, const SceneArray& array) {
  return scene.count * array.width * sizeof(float);
}

}  // namespace

Mapping::Mapping(int descriptor, std::size_t bytes) {
  if (bytes == 0) return;
  void* const data = mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED, descriptor, 0);
  if (data == MAP_FAILED) refuse("mmap", bytes);
  data_ = {static_cast<std::byte*>(data), Unmap{bytes}};
}

void Mapping::Unmap::operator()(std::byte* data) const { munmap(data, bytes); }

SharedMemory::SharedMemory() : file_(memfd_create("quadsplat plugin", MFD_CLOEXEC)) {
  if (!file_) fail(ErrorKind::device, "plugin: memfd_create: {}", std::strerror(errno));
}

void SharedMemory::resize(std::size_t bytes) {
  if (bytes == mapping_.size()) return;
  mapping_ = {};
  // The pages are allocated here: if the allocation of a page failed later, the process that
  // touches the page would be killed.
  if (ftruncate(file_.get(), 0) != 0) refuse("ftruncate", bytes);
  const int error = bytes == 0 ? 0 : posix_fallocate(file_.get(), 0, static_cast<off_t>(bytes));
  if (error != 0) {
    errno = error;
    refuse("posix_fallocate", bytes);
  }
  mapping_ = Mapping(file_.get(), bytes);
}

std::vector<SceneArray> scene_arrays(const QsScene& scene) {
  const auto coefficients = static_cast<std::size_t>(sh_coefficient_count(scene.sh_degree));
  std::vector<SceneArray> arrays = {
      {&QsScene::positions, 3, 0},         {&QsScene::log_scales, 3, 0},
      {&QsScene::rotations, 4, 0},         {&QsScene::opacity_logits, 1, 0},
      {&QsScene::sh, 3 * coefficients, 0}, {&QsScene::covariances, 6, 0},
      {&QsScene::opacities, 1, 0}};
  std::size_t offset = 0;
  for (SceneArray& array : arrays) {
    array.offset_bytes = offset;
    offset += (bytes_of(scene, array) + kAlignment - 1) / kAlignment * kAlignment;
  }
  return arrays;
}

std::size_t scene_bytes(const QsScene& scene) {
  const SceneArray last = scene_arrays(scene).back();
  return last.offset_bytes + bytes_of(scene, last);
}

void point_into(const Mapping& memory, QsScene& scene) {
  for (const SceneArray& array : scene_arrays(scene))
    scene.*array.member = memory.floats(array.offset_bytes);
}

QsScene fill_scene(const GaussianCloud& cloud, ThreadPool& pool, SharedMemory& memory) {
  QsScene scene = {};
  scene.count = cloud.size();
  scene.sh_degree = cloud.sh_degree;
  memory.resize(scene_bytes(scene));
  QsScene arrays = scene;
  point_into(memory.mapping(), arrays);
  const auto writable = [](const float* array) { return const_cast<float*>(array); };
  const auto coefficients = static_cast<std::size_t>(sh_coefficient_count(cloud.sh_degree));
  pool.for_each(cloud.size(), 1 << 14, [&](std::size_t i) {
    const glm::quat& rotation = cloud.rotations[i];
    const float quaternion[] = {rotation.w, rotation.x, rotation.y, rotation.z};
    const Activated active = activate(cloud, i);
    const Covariance3<float>& c = active.gaussian.covariance;
    const float covariance[] = {c.xx, c.xy, c.xz, c.yy, c.yz, c.zz};
    std::memcpy(writable(arrays.positions) + 3 * i, &cloud.positions[i], sizeof(float[3]));
    std::memcpy(writable(arrays.log_scales) + 3 * i, &cloud.log_scales[i], sizeof(float[3]));
    std::memcpy(writable(arrays.rotations) + 4 * i, quaternion, sizeof quaternion);
    std::memcpy(writable(arrays.sh) + 3 * coefficients * i, &cloud.sh[coefficients * i],
                coefficients * sizeof(float[3]));
    std::memcpy(writable(arrays.covariances) + 6 * i, covariance, sizeof covariance);
    writable(arrays.opacity_logits)[i] = cloud.opacity_logits[i];
    writable(arrays.opacities)[i] = active.opacity;
  });
  return scene;
}

QsView view_of(const Camera& camera, const RenderSettings& settings, int sh_degree,
               bool antialiased) {
  QsView view = {};
  std::copy_n(glm::value_ptr(glm::transpose(camera.view_from_world)), 12, view.view_from_world);
  std::copy_n(&camera.focal_px.x, 2, view.focal_px);
  std::copy_n(&camera.center_px.x, 2, view.center_px);
  view.near_depth = camera.near_depth;
  view.dilation_px2 = settings.dilation;
  std::copy_n(&settings.background.x, 3, view.background);
  view.splat_scale = settings.splat_scale;
  view.width = camera.width;
  view.height = camera.height;
  view.sh_degree = std::min(settings.sh_degree, sh_degree);
  view.antialiased = settings.antialiased.value_or(antialiased) ? 1 : 0;
  return view;
}

}  // namespace qs
