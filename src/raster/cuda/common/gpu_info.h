// SPDX-License-Identifier: MIT
//
// Lists the GPUs, or gives the reason why none can be used; locates them on the bus. Plain C++.
#pragma once

#include <optional>

#include "raster/api/renderer.h"

namespace qs::cuda {

/// See the functions of these names in namespace qs.
GpuReport gpu_report();
GpuReport cuda_versions();
Gpu inspect_gpu(int device);
std::optional<int> find_gpu();

/// Throws Error(device) with the reason if a GPU, an index into GpuReport::gpus, cannot be used.
void require_gpu(int device);

/// The PCI bus address of a GPU, such as "0000:1b:00.0"; empty if there is none with this index.
std::string pci_bus_id(int device);

}  // namespace qs::cuda
