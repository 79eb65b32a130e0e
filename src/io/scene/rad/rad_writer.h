// SPDX-License-Identifier: MIT
//
// Writes a .rad file chunk by chunk. Every viewer draws the nodes as ordinary Gaussians: opacities
// are at most 1. Behind the properties of a chunk is a block that other readers skip, named by the
// key "quadsplat" of the chunk's description: offset and bytes in the payload, crc32 of the
// deflated bytes. Unpacked it has, for the nodes of the chunk,
//   u8 gains[8], u8 errors[8]          planes, the smallest footprint first
//   f16 log2 of layers, of opacities, of radius     planes; -65504 for 0
//   u32 parent                         plane
// With "original" in "quadsplat", a second such block follows: the words of rad_original.h of the
// leaves, in byte planes: the lowest bytes of the first word of all leaves come first.
// The description of the file has "quadsplat" too: the smallest footprint, and the origin from
// which centres count.
#pragma once

#include <cstddef>
#include <cstdint>
#include <iosfwd>
#include <span>
#include <string>
#include <vector>

#include <glm/vec3.hpp>

#include "base/parallel.h"
#include "raster/pages/lod_node.h"

namespace qs {

/// Nodes with their SH in halves: RGB triples, degree 0 first.
struct RadNodes {
  std::vector<LodNode> nodes;  ///< their parent and first_child count from the root of the file
  std::vector<std::uint16_t> sh;
  std::vector<std::uint32_t> original;  ///< original_words() of each leaf, in their order; or empty

  /// Appends nodes [begin, end) of others, which have the same SH degree.
  void append(const RadNodes& from, std::size_t begin, std::size_t end);
};

struct RadPlan {
  std::uint64_t nodes = 0;  ///< of the file, 1 to 2^32 - 1
  int sh_degree = 0;        ///< 0..3
  float footprint = 1;      ///< the smallest one
  bool antialiased = false;
  bool original = false;   ///< all nodes have RadNodes::original
  glm::dvec3 origin{0.0};  ///< GaussianCloud::origin
};

class RadWriter {
 public:
  static constexpr std::size_t kChunk = 65536;

  /// Leaves room for the header in the stream, which can seek.
  RadWriter(std::ostream& stream, const RadPlan& plan, ThreadPool& pool);

  /// Writes the next chunks. Each has kChunk nodes, but the last one of the file.
  void write(std::span<const RadNodes> chunks);

  /// Writes the header.
  void finish();

 private:
  std::string header(bool is_final) const;

  std::ostream& stream_;
  RadPlan plan_;
  ThreadPool& pool_;
  std::vector<std::uint64_t> chunk_bytes_;
  std::uint64_t header_bytes_ = 0, next_ = 0;  // next_: node
};

}  // namespace qs
