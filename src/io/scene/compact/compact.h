// SPDX-License-Identifier: MIT
//
// Compact-3DGS (Lee et al. 2024): Gaussians whose colours a hash grid and a network compute. The
// cloud gets spherical harmonics of degree 3 that are fitted to the network in 24 directions;
// Scene::network keeps the network and the size of the difference.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>

#include "base/parallel.h"
#include "io/bytes/byte_text.h"
#include "io/cloud/scene.h"

namespace qs {

RecogniseScene recognises_compact;
ReadScene read_compact;

/// The difference between spherical harmonics and network, as a sentence.
std::string fit_sentence(const NetworkColors& network);

}  // namespace qs
