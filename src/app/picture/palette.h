// SPDX-License-Identifier: MIT
//
// Colours of drawings on white, and of the modes: a mode has the same colour in every plot, drawing
// and table. The modes' colours are Okabe and Ito's, which colour-blind people can tell apart.
#pragma once

#include <string>

#include <glm/vec3.hpp>

#include "raster/kernel/cull/modes.h"

namespace qs {

/// "#0072B2" for "quadbox"; grey for a name that is no mode.
std::string mode_color(const std::string& mode);

namespace paper {

inline constexpr glm::vec3 kWhite{1.0f}, kInk{0.10f, 0.11f, 0.13f}, kFaint{0.42f, 0.44f, 0.48f},
    kPanel{0.965f, 0.967f, 0.972f};

/// RGB of qs::mode_color(), 0..1.
glm::vec3 mode_color(CullMode mode);

}  // namespace paper
}  // namespace qs
