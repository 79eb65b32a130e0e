// SPDX-License-Identifier: MIT
//
// The pixels of a frame as visitors see them: with its heat map and legend, beside the other frame
// of a split window, or as their difference. The window draws the same by shaders/present.frag.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "app/viewer/render/render_context.h"

namespace qs {

/// 8-bit RGBA, rows from the top. `split`: of a frame with a second frame; an amplification of 0 is
/// chosen from the frames.
std::vector<std::uint8_t> painted(const FrameRequest& request, const std::optional<Split>& split,
                                  RenderedFrame frame);

}  // namespace qs
