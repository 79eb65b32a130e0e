// SPDX-License-Identifier: MIT
//
// The description of a .rad file, and its chunks as Gaussians. All functions throw Error(input) if
// the file is damaged.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "io/cloud/linear_values.h"
#include "io/scene/rad/rad_chunk.h"

namespace qs {

inline constexpr std::string_view kRadFileMagic = "RAD0";

struct RadHeader {
  std::uint64_t count = 0, chunk_nodes = 0;  ///< of the file and of a chunk
  bool has_tree = false, antialiased = false, has_originals = false;
  glm::dvec3 origin{0.0};              ///< GaussianCloud::origin
  float footprint = 0;                 ///< the smallest one; 0: another program wrote the file
  std::optional<std::uint64_t> codes;  ///< rows of its tables of SH
  struct Range {
    std::uint64_t offset = 0, bytes = 0;  ///< from the end of the description
    std::optional<std::string> file;      ///< a file beside it; unset: in this one
  };
  std::vector<Range> chunks;

  /// Throws unless chunk `i` lies in the `bytes` behind the description.
  void require_inside(std::size_t i, std::uint64_t bytes, const std::string& source) const;

  /// Chunk `i`, whose bytes must outlive it.
  RadChunk chunk(std::size_t i, ByteSpan content, const std::string& source) const;
};

/// Leaves the cursor behind the description.
RadHeader read_rad_header(ByteCursor& cursor, const std::string& source);

/// The tables of SH in the first chunk, from which nodes of all chunks choose a row.
struct RadCodes {
  explicit RadCodes(const RadChunk& first);

  std::array<Array<float>, 3> bands;
  std::size_t rows = 0;
};

/// Fills Gaussians `places[i]` of a cloud, which has the SH of the chunk, from `rows[i]` of the
/// chunk. Returns the number of Gaussians whose SH are not in the tables.
std::size_t fill_gaussians(const RadChunk& chunk, const RadCodes& codes,
                           std::span<const std::uint32_t> rows,
                           std::span<const std::uint32_t> places, GaussianCloud& cloud,
                           LinearValues& linear);

}  // namespace qs
