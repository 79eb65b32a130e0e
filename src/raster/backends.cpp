// SPDX-License-Identifier: MIT
// Compiled alone: the tests on an emulated GPU replace this file.
#include <optional>
#include <vector>

#include "base/fail.h"
#include "raster/api/renderer.h"
#include "raster/cpu/renderer.h"
#include "raster/lens/lens_renderer.h"
#ifdef QUADSPLAT_HAVE_CUDA
#include "raster/cuda/common/gpu_info.h"
#include "raster/cuda/lens_renderer.h"
#include "raster/cuda/renderer.h"
#endif

namespace qs {

#ifdef QUADSPLAT_HAVE_CUDA
GpuReport gpu_report() { return cuda::gpu_report(); }
GpuReport cuda_versions() { return cuda::cuda_versions(); }
Gpu inspect_gpu(int device) { return cuda::inspect_gpu(device); }
#else
GpuReport gpu_report() { return {{}, {}, {}, "this program was built without CUDA"}; }
GpuReport cuda_versions() { return gpu_report(); }
Gpu inspect_gpu(int /*device*/) {
  Gpu none;
  none.problem = gpu_report().problem;
  return none;
}
#endif

namespace {

// Empty if no GPU can be used.
std::optional<int> found_gpu() {
#ifdef QUADSPLAT_HAVE_CUDA
  static const std::optional<int> kFound = cuda::find_gpu();
  return kFound;
#else
  return std::nullopt;
#endif
}

}  // namespace

int first_gpu() { return found_gpu().value_or(0); }

std::span<const Backend> available_backends() {
  static const std::vector<Backend> kBackends =
      found_gpu() ? std::vector{Backend::cuda, Backend::cpu} : std::vector{Backend::cpu};
  return kBackends;
}

std::unique_ptr<Renderer> make_renderer(Backend backend, ThreadPool& pool,
                                        [[maybe_unused]] int device) {
  if (backend == Backend::cpu) return with_lenses(make_cpu_renderer(pool), pool);
#ifdef QUADSPLAT_HAVE_CUDA
  const int gpu = device == kFirstGpu ? first_gpu() : device;
  return with_lenses_on_gpu(make_cuda_renderer(pool, gpu), pool, gpu);
#else
  fail(ErrorKind::device, "backend cuda: {}", gpu_report().problem);
#endif
}

}  // namespace qs
