// SPDX-License-Identifier: MIT
//
// Colours of drawings on white, and of the modes, which have the same colour in every plot, drawing
// and table.
#pragma once

#include <glm/vec3.hpp>

#include "raster/kernel/cull/list.h"

namespace qs::paper {

inline constexpr glm::vec3 kWhite{1.0f}, kInk{0.10f, 0.11f, 0.13f}, kFaint{0.42f, 0.44f, 0.48f},
    kLine{0.80f, 0.81f, 0.83f}, kPanel{0.965f, 0.967f, 0.972f};

/// Of mode_color() in bench/plot.h.
glm::vec3 mode_color(CullMode mode);

}  // namespace qs::paper
