// SPDX-License-Identifier: MIT
// Compiled alone: the tests on an emulated GPU replace this file.
#include "learn/step/training_model.h"

#include "base/fail.h"
#include "learn/step/cpu/cpu_model.h"
#ifdef QUADSPLAT_HAVE_CUDA
#include "learn/step/cuda/gpu_model.h"
#endif

namespace qs::train {

std::unique_ptr<TrainingModel> make_training_model(Backend backend, ThreadPool& pool,
                                                   [[maybe_unused]] int device) {
  if (backend == Backend::cpu) return std::make_unique<cpu::train::CpuModel>(pool);
#ifdef QUADSPLAT_HAVE_CUDA
  return std::make_unique<cuda::train::GpuModel>(device == kFirstGpu ? first_gpu() : device);
#else
  fail(ErrorKind::device, "backend cuda: {}", gpu_report().problem);
#endif
}

}  // namespace qs::train
