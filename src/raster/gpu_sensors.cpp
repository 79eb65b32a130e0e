// SPDX-License-Identifier: MIT
#include "raster/clock/gpu_clock.h"
#ifdef QUADSPLAT_HAVE_CUDA
#include "raster/cuda/common/gpu_info.h"
#endif

namespace qs {

GpuSensors gpu_sensors([[maybe_unused]] int device) {
#ifdef QUADSPLAT_HAVE_CUDA
  const std::string address = cuda::pci_bus_id(device);
  return address.empty() ? GpuSensors() : nvml_sensors(address);
#else
  return {};
#endif
}

}  // namespace qs
