// SPDX-License-Identifier: MIT
//
// The sensors of an NVIDIA GPU through NVML, the management library that comes with the driver. It
// is loaded at run time, so a program that uses it also starts on machines without it.
#pragma once

#include <string>

#include "raster/clock/gpu_clock.h"

namespace qs {

/// The sensors of the GPU at a PCI bus address such as "0000:1b:00.0". NVML numbers GPUs
/// differently from CUDA, so an index does not identify one. There are no sensors if `library`
/// cannot be loaded, is too old, or does not know the GPU.
GpuSensors nvml_sensors(const std::string& pci_bus_id, const char* library = "libnvidia-ml.so.1");

}  // namespace qs
