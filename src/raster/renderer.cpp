// SPDX-License-Identifier: MIT
#include "raster/renderer.h"

#include <array>

#include "raster/cpu/cpu_renderer.h"
#include "raster/scene/fail.h"

namespace qs {

std::span<const Backend> available_backends() {
  static constexpr std::array kBackends = {Backend::cpu};
  return kBackends;
}

std::unique_ptr<Renderer> make_renderer(Backend backend, int threads) {
  if (backend == Backend::cpu) return make_cpu_renderer(threads);
  fail(ErrorKind::device, "backend cuda: this build has no CUDA backend");
}

}  // namespace qs
