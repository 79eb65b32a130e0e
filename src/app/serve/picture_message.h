// SPDX-License-Identifier: MIT
//
// The binary messages of the server: a picture behind this header of 96 bytes, little-endian. A
// lossless picture is a number of strips of the full width, each an image file. Each file comes in
// parts, which all have a header.
//
//   byte  0  u8   1: a picture           byte 24  u64  microseconds of the server's clock
//         1  u8   PictureCodec                32  f64  position x, y, z in the world
//         2  u8   flags: 1 key, 2 lossless,   56  f64  rotation view from world, quaternion x, y,
//         z, w
//                 4 last part of the strip    88  f32  fx, fy in pixels of the picture
//                 8 last strip
//         3  u8   divisor
//         4  u32  number of the picture
//         8  u32  the last input that it answers
//        12  u32  version of the state
//        16  u16  width, height
//        20  u16  first row of the strip
//        22  u16  0
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

#include "app/serve/pictures.h"

namespace qs {

inline constexpr std::size_t kPictureHeader = 96;
/// The longest part of a picture file in a message, so that input can stop the rest.
inline constexpr std::size_t kPicturePart = 16384;

inline constexpr std::uint8_t kKeyFlag = 1, kLosslessFlag = 2, kLastPartFlag = 4,
                              kLastStripFlag = 8;

/// The facts in a header that are not of the picture itself.
struct PictureNumbers {
  std::uint32_t picture = 0, state = 0;
  std::uint64_t microseconds = 0;
};

/// The message with the bytes from `begin` on; `begin` < its number of bytes.
std::string picture_message(const Picture& picture, const PictureNumbers& numbers,
                            std::size_t begin);

/// The first byte behind the part that begins there.
std::size_t end_of_part(const Picture& picture, std::size_t begin);

/// The pictures of one codec that visitors got.
struct SentPictures {
  std::uint64_t pictures = 0, bytes = 0;
  double encode_ms = 0, send_ms = 0;  ///< of all; sending ends when the system has taken the bytes
};

// ---- files
// ---------------------------------------------------------------------------------------- A file
// that a visitor's page saves, such as a film: binary messages with parts of it, each behind this
// header, little-endian. The page confirms them as it confirms pictures.
//
//   byte 0  u8   2: a file                byte 4  u32  number of the file
//        1  u8   flags: 4 last part            8  u64  bytes of the whole file
//        2  u16  bytes of the name            16       the name, UTF-8

/// The longest part of a file in a message.
inline constexpr std::size_t kFilePart = 32768;

struct SentFile {
  std::string name;  ///< without folders
  std::shared_ptr<const std::string> bytes;
};

/// The message with the part from `begin` on, which may be empty. `begin` <= its size.
std::string file_message(const SentFile& file, std::uint32_t number, std::size_t begin);

/// The name without folders, and with letters, digits and "._- " only; never empty.
std::string harmless_name(const std::string& name);

}  // namespace qs
