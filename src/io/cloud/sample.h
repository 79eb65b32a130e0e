// SPDX-License-Identifier: MIT
//
// Samples of scenes that are being read; see Sampling.
#pragma once

#include "io/cloud/scene.h"

namespace qs {

/// True if `sampling` requests a sample of a scene with `count` Gaussians.
bool is_sampled(std::size_t count, const Sampling& sampling);

/// The sample of a complete scene.
SceneSample sample_of(const Scene& scene, const Sampling& sampling);

}  // namespace qs
