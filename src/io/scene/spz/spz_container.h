// SPDX-License-Identifier: MIT
//
// Unpacks an .spz file into its uncompressed blocks. The header's claims are checked against each
// other and against the file's size before anything is allocated, and never more is decompressed
// than the header implies.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "base/parallel.h"
#include "base/progress.h"
#include "io/bytes/byte_text.h"
#include "raster/scene/gaussian_cloud.h"

namespace qs {

inline constexpr std::uint32_t kSpzMagic = 0x5053474e;  ///< "NGSP"
inline constexpr std::uint32_t kSpzHeaderBytes = 32;    ///< in version 4

struct SpzHeader {
  std::uint32_t version = 0;         ///< 1..4
  std::uint32_t count = 0;           ///< Gaussians
  std::uint8_t sh_degree = 0;        ///< 0..4
  std::uint8_t fractional_bits = 0;  ///< positions have 0..24; version 1 has floats instead
  std::uint8_t flags = 0;

  static constexpr std::uint8_t kAntialiased = 0x1, kExtensions = 0x2, kLodTree = 0x80;
};

enum SpzBlock {
  kSpzPositions,
  kSpzAlphas,
  kSpzColors,
  kSpzScales,
  kSpzRotations,
  kSpzSh,
  kSpzChildCounts,  ///< 16 bits, of a tree of levels of detail
  kSpzChildStarts,  ///< 32 bits
  kSpzBlocks
};

/// Bytes per Gaussian in each block.
std::array<std::uint64_t, kSpzBlocks> spz_row_bytes(const SpzHeader& header);

struct SpzContent {
  SpzHeader header;
  Array<std::byte> bytes;                   ///< all blocks
  std::array<ByteSpan, kSpzBlocks> blocks;  ///< into `bytes`
  Array<std::byte> extensions;              ///< records, see spz.cpp
  std::vector<std::string> warnings;
};

/// True for the plain container of version 4 and for gzip data that begins with the .spz magic.
bool is_spz(ByteSpan content);

using UseSpz = std::function<void(const SpzContent& content)>;

/// Reports progress from 0 to `end`. Data in gzip is unpacked in the order of its blocks:
/// `base_is_there` is called once all blocks before kSpzSh are unpacked. Throws
/// Error(input), Cancelled.
SpzContent unpack_spz(ByteSpan content, const std::filesystem::path& path, ThreadPool& pool,
                      const Progress& progress, float end, const UseSpz& base_is_there);

}  // namespace qs
