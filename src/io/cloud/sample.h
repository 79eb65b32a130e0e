// SPDX-License-Identifier: MIT
//
// Samples of scenes that are being read; see Sampling.
#pragma once

#include "io/cloud/scene.h"

namespace qs {

/// Whether a sample of a scene with `count` Gaussians is wanted.
bool is_sampled(std::size_t count, const Sampling& sampling);

/// The sample of a scene that is complete.
SceneSample sample_of(const Scene& scene, const Sampling& sampling);

}  // namespace qs
