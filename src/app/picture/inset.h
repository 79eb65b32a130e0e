// SPDX-License-Identifier: MIT
//
// A part of a picture, enlarged, as papers show details beside or in a picture.
#pragma once

#include "app/picture/canvas.h"

namespace qs {

/// Size of the enlarged part, pixels.
glm::ivec2 enlarged_size(PixelRect part, double zoom);

/// A part of an RGB picture, `zoom` >= 1 times as large, interpolated linearly between pixels.
/// `part` is inside the picture. Values are clamped to 0..1.
Image enlarged(const Image& image, PixelRect part, double zoom);

/// The picture with a frame around `part` and the enlarged part in the corner farthest from it.
/// The enlarged part is not larger than the picture.
Image with_inset(const Image& image, PixelRect part, double zoom);

}  // namespace qs
