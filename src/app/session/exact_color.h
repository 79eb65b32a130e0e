// SPDX-License-Identifier: MIT
//
// A renderer that draws the colours that a scene's network computes for the view, instead of the
// spherical harmonics that were fitted to them.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "io/cloud/scene.h"
#include "raster/api/renderer.h"

namespace qs {

/// `network` is the scene's, `axes` are Scene::axes. `pool` evaluates the network and must outlive
/// the result. Each new position of the camera is uploaded again, which frame times do not include;
/// everything else works as in `inner`.
std::unique_ptr<Renderer> with_exact_color(std::unique_ptr<Renderer> inner,
                                           const NetworkColors& network, const std::string& axes,
                                           ThreadPool& pool);

/// The cloud as it is seen from `eye`: positions and shapes of `cloud`, colours of the network.
/// Throws Cancelled.
GaussianCloud seen_from(const glm::dvec3& eye, const GaussianCloud& cloud,
                        const NetworkColors& network, const std::string& axes, ThreadPool& pool);

}  // namespace qs
