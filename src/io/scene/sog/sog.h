// SPDX-License-Identifier: MIT
//
// SOG (PlayCanvas), versions 1 and 2: meta.json and WebP pictures, in a folder or zipped; and
// streamed SOG: lod-meta.json, a tree whose leaves are parts of several SOG scenes. Its finest
// level is read.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "base/parallel.h"
#include "io/bytes/byte_text.h"
#include "io/bytes/zip.h"
#include "io/cloud/scene.h"

namespace qs {

RecogniseScene recognises_sog, recognises_streamed_sog;
ReadScene read_sog, read_streamed_sog;

/// Writes version 2 in a zip, along a Morton curve. Scales, colours and SH are entries of codebooks
/// of 256 values; the SH of a Gaussian are one of at most 65,536 vectors. Throws Error(input) for
/// more Gaussians than WebP pictures hold.
WriteScene write_sog;

/// A level of a streamed SOG, whose Gaussians need not be in memory.
struct SogLevel {
  std::vector<glm::vec3> centers;
  std::vector<float> sigmas;  ///< the largest standard deviation of each, world units
  /// The Gaussians with these numbers, in this order.
  std::function<GaussianCloud(std::span<const std::uint32_t> numbers)> gaussians;
};

/// Writes a streamed SOG: lod-meta.json, and a folder for each SOG of at most 524,288 Gaussians.
/// `levels` are pictures of one scene, the finest first. The leaves of its tree have at most as
/// many Gaussians; a leaf wider than 16 units has at most 8,192 in its finest level. Each has a
/// part of every level, in places an empty one. Throws Error(input), and as replace_folder().
void write_streamed_sog(std::span<const SogLevel> levels, const std::filesystem::path& folder,
                        ThreadPool& pool, const Progress& progress);

struct SogPicture {
  std::string name;
  std::size_t width, height;
  std::vector<std::uint8_t> values;  ///< RGBA; texels that nothing uses are 0
};

/// A SOG before its pictures are encoded.
struct SogPictures {
  std::string meta;  ///< meta.json
  std::vector<SogPicture> pictures;
};

/// The pictures of a SOG. Gaussians keep their order.
SogPictures sog_pictures(const GaussianCloud& cloud, ThreadPool& pool, const Progress& progress);

/// The files of each SOG. All pictures are encoded at once, by all threads.
std::vector<std::vector<ZipEntry>> encode_pictures(std::span<const SogPictures> scenes,
                                                   ThreadPool& pool, const std::stop_token& stop);

}  // namespace qs
