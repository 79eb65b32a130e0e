// SPDX-License-Identifier: MIT
//
// The CPU backend: preprocess, sort, bin, blend, each in the file of its name. It is the oracle of
// every other backend, and renders where there is no GPU.
#pragma once

#include <memory>

#include "raster/renderer.h"

namespace qs {

std::unique_ptr<Renderer> make_cpu_renderer(int threads);

}  // namespace qs
