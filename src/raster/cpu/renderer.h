// SPDX-License-Identifier: MIT
//
// The CPU backend, for machines without a GPU. Its images and tile lists are the ground truth for
// every other backend. Pipelines `fast` and `classic` and mode reference are in folders and files
// of their names.
#pragma once

#include <memory>

#include "raster/api/renderer.h"

namespace qs {

std::unique_ptr<Renderer> make_cpu_renderer(ThreadPool& pool);

}  // namespace qs
