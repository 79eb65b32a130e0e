// SPDX-License-Identifier: MIT
//
// Compares two images of one view by their 8-bit RGB values, as in a PNG file or on a display.
#pragma once

#include <cstdint>
#include <filesystem>
#include <limits>
#include <optional>
#include <span>

#include <glm/vec2.hpp>

#include "app/picture/canvas.h"
#include "raster/api/renderer.h"

namespace qs {

struct ImageDifference {
  double psnr = std::numeric_limits<double>::infinity();  ///< dB over all RGB values, peak 255
  int largest = 0;                                        ///< largest difference of an 8-bit value
  glm::ivec2 largest_at{-1};        ///< the first pixel, row by row, that has it
  std::uint64_t pixels = 0;         ///< pixels that differ by more than the tolerance
  std::optional<glm::ivec2> first;  ///< the first of these pixels, row by row
  int usual = 0;  ///< at most one in fifty of the pixels that differ at all differs by more
};

/// Compares the pixels of `box`, default: of the whole image. Both images have the same size and at
/// least three channels.
ImageDifference image_difference(const Image& a, const Image& b,
                                 const std::optional<PixelBox>& box = {}, int tolerance = 0);

/// Compares RGBA images with 8 bits per channel and rows of `width` pixels. Alpha is ignored.
ImageDifference image_difference(std::span<const std::uint8_t> a, std::span<const std::uint8_t> b,
                                 int width, const PixelBox& box);

/// |a - b| of one 8-bit value.
int difference_8bit(const Image& a, const Image& b, int x, int y, int channel);

/// A picture of |a - b| inside the box, times `amplification` and at most 1.
Image amplified_difference(const Image& a, const Image& b, const PixelBox& box, int amplification);

/// The largest factor, 1 to 64, by which a difference can be amplified without clipping.
int amplification_for(int largest_difference);

/// The largest power of two, 1 to 128, that does not clip the usual difference.
int visible_amplification(const ImageDifference& difference);

/// All pixels of the image.
PixelBox box_of(const Image& image);
/// The pixels of the box.
PixelRect rect_of(const PixelBox& box);

/// Reads a picture of this size as RGB. Throws Error(input), also if the picture has another size.
Image read_reference(const std::filesystem::path& path, int width, int height);

/// OUT.png -> OUT.difference.png; always a PNG.
std::filesystem::path difference_path(const std::filesystem::path& output);

}  // namespace qs
