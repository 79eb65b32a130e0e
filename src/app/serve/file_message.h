// SPDX-License-Identifier: MIT
//
// A file that a visitor's page saves, such as a film: binary messages with parts of it, each behind
// this header, little-endian. The page confirms them as it confirms pictures.
//
//   byte 0  u8   2: a file                byte 4  u32  number of the file
//        1  u8   flags: 4 last part            8  u64  bytes of the whole file
//        2  u16  bytes of the name            16       the name, UTF-8
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

namespace qs {

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
