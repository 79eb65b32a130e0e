// SPDX-License-Identifier: MIT
//
// Formats with linear scales and opacities (glTF, OpenUSD): conversion to a cloud's logarithms and
// logits. Values out of range are clamped and counted, from several threads.
#pragma once

#include <atomic>
#include <cmath>
#include <cstddef>

#include <glm/common.hpp>
#include <glm/exponential.hpp>

#include "io/cloud/scene.h"

namespace qs {

struct LinearValues {
  std::atomic<std::size_t> negative_scales = 0, odd_opacities = 0;

  glm::vec3 log_scale(const glm::vec3& scale) {
    if (scale.x < 0 || scale.y < 0 || scale.z < 0) ++negative_scales;
    return glm::log(glm::max(scale, glm::vec3(0)));
  }

  float logit(double opacity) {
    if (opacity < 0 || opacity > 1) ++odd_opacities;
    const double inside = opacity < 0 ? 0 : opacity > 1 ? 1 : opacity;  // NaN stays
    return static_cast<float>(std::log(inside / (1 - inside)));
  }

  void warn(Scene& scene) const {
    if (negative_scales > 0)
      scene.warn("{} Gaussians have a negative scale, which was taken for 0.",
                 negative_scales.load());
    if (odd_opacities > 0)
      scene.warn("{} Gaussians have an opacity outside 0 to 1, which was clamped.",
                 odd_opacities.load());
  }
};

}  // namespace qs
