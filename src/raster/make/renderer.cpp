// SPDX-License-Identifier: MIT
#include "raster/api/renderer.h"

#include "raster/base/fail.h"
#include "raster/make/cpu_renderer.h"
#ifdef QUADSPLAT_HAVE_CUDA
#include "raster/cuda/gpu_info.h"
#include "raster/make/cuda_renderer.h"
#endif

namespace qs {

GpuReport gpu_report() {
#ifdef QUADSPLAT_HAVE_CUDA
  return cuda::gpu_report();
#else
  GpuReport report;
  report.problem = "this program was built without CUDA";
  return report;
#endif
}

std::span<const Backend> available_backends() {
  static const std::vector<Backend> kBackends = gpu_report().problem.empty()
                                                    ? std::vector{Backend::cuda, Backend::cpu}
                                                    : std::vector{Backend::cpu};
  return kBackends;
}

std::unique_ptr<Renderer> make_renderer(Backend backend, ThreadPool& pool,
                                        [[maybe_unused]] int device) {
  if (backend == Backend::cpu) return make_cpu_renderer(pool);
#ifdef QUADSPLAT_HAVE_CUDA
  return make_cuda_renderer(pool, device);
#else
  fail(ErrorKind::device, "backend cuda: {}", gpu_report().problem);
#endif
}

}  // namespace qs
