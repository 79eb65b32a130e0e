// SPDX-License-Identifier: MIT
#include <cuda_runtime.h>

#include "base/error.h"
#include "raster/cuda/common/gpu_info.h"

namespace qs::cuda {
namespace {

/// Its attributes can be queried only on a GPU for which this build contains code.
__global__ void probe() {}

std::string version_text(int version) {
  return std::to_string(version / 1000) + "." + std::to_string(version % 1000 / 10);
}

Gpu inspect(int device) {
  Gpu gpu;
  cudaDeviceProp properties{};
  cudaFuncAttributes attributes{};
  std::size_t free = 0, total = 0;
  cudaError_t error = cudaGetDeviceProperties(&properties, device);
  if (error == cudaSuccess) {
    gpu.name = properties.name;
    gpu.total_bytes = properties.totalGlobalMem;
    gpu.major = properties.major;
    gpu.minor = properties.minor;
    error = cudaSetDevice(device);
  }
  if (error == cudaSuccess) error = cudaMemGetInfo(&free, &total);
  if (error == cudaSuccess) error = cudaFuncGetAttributes(&attributes, probe);
  gpu.free_bytes = free;
  if (error == cudaErrorNoKernelImageForDevice || error == cudaErrorInvalidDeviceFunction) {
    gpu.problem = "this program has no code for compute capability " + std::to_string(gpu.major) +
                  "." + std::to_string(gpu.minor);
  } else if (error != cudaSuccess) {
    gpu.problem = cudaGetErrorString(error);
  }
  cudaGetLastError();  // clears the error of a failed query
  return gpu;
}

/// The reason why cudaGetDeviceCount found no GPU. A missing driver and an outdated driver give the
/// same error; only the driver's version distinguishes them.
std::string why_none(cudaError_t error, int driver, int runtime) {
  if (driver == 0)
    return "no NVIDIA driver was found: a GPU needs one for CUDA " + version_text(runtime) +
           " or newer";
  if (error == cudaErrorInsufficientDriver)
    return "the NVIDIA driver is too old: it supports CUDA " + version_text(driver) +
           ", this program needs one for CUDA " + version_text(runtime) + " or newer";
  if (error == cudaSuccess || error == cudaErrorNoDevice) return "there is no NVIDIA GPU";
  return std::string("the GPU cannot be used: ") + cudaGetErrorString(error);
}

/// The report without its GPUs, whose number is set. Opens no context on a GPU.
GpuReport count_gpus(int& count) {
  GpuReport report;
  int driver = 0, runtime = 0;
  count = 0;
  cudaDriverGetVersion(&driver);
  cudaRuntimeGetVersion(&runtime);
  report.runtime = version_text(runtime);
  if (driver > 0) report.driver = version_text(driver);
  const cudaError_t error = cudaGetDeviceCount(&count);  // does not set the count if it fails
  cudaGetLastError();
  if (error != cudaSuccess) count = 0;
  if (count == 0) report.problem = why_none(error, driver, runtime);
  return report;
}

}  // namespace

GpuReport cuda_versions() {
  int count = 0;
  return count_gpus(count);
}

GpuReport gpu_report() {
  int count = 0;
  GpuReport report = count_gpus(count);
  for (int device = 0; device < count; ++device) report.gpus.push_back(inspect_gpu(device));
  for (const Gpu& gpu : report.gpus)
    if (gpu.problem.empty()) return report;
  if (count > 0)
    report.problem = report.gpus[0].name + " cannot be used: " + report.gpus[0].problem;
  return report;
}

Gpu inspect_gpu(int device) {
  int count = 0;
  const GpuReport report = count_gpus(count);
  if (device < 0 || device >= count) {
    Gpu none;
    none.problem = count == 0 ? report.problem
                              : "there is no GPU " + std::to_string(device) +
                                    ", they count from 0 to " + std::to_string(count - 1);
    return none;
  }
  int current = 0;
  cudaGetDevice(&current);
  Gpu gpu = inspect(device);
  cudaSetDevice(current);
  cudaGetLastError();
  return gpu;
}

std::optional<int> find_gpu() {
  int count = 0;
  count_gpus(count);
  for (int device = 0; device < count; ++device)
    if (inspect_gpu(device).problem.empty()) return device;
  return std::nullopt;
}

void require_gpu(int device) {
  const Gpu gpu = inspect_gpu(device);
  if (gpu.problem.empty()) return;
  throw Error(ErrorKind::device,
              "backend cuda: " + (gpu.name.empty() ? "" : gpu.name + ": ") + gpu.problem);
}

std::string pci_bus_id(int device) {
  char text[32] = "";
  const bool found = cudaDeviceGetPCIBusId(text, sizeof text, device) == cudaSuccess;
  cudaGetLastError();  // clears the error of a failed query
  return found ? text : "";
}

}  // namespace qs::cuda
