// SPDX-License-Identifier: MIT
//
// One SOG scene in memory: its decoded pictures, and the conversion of their texels into Gaussians.
// Before anything is decoded, each picture's size is read from its header and checked against the
// number of Gaussians, and the number of Gaussians against the bytes of all pictures.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include <glm/vec3.hpp>

#include "base/parallel.h"
#include "io/bytes/file_source.h"
#include "raster/scene/gaussian_cloud.h"

namespace qs {

// meta.json of a SOG scene in one form for versions 1 and 2: the picture that holds each value, and
// the meaning of its bytes.

using ByteTable = std::array<float, 256>;

struct SogMeta {
  int version = 0;          ///< 1 or 2
  std::string model;        ///< "antialiased", "2dgs", ...; empty: Gaussians as usual
  std::uint64_t count = 0;  ///< Gaussians, at least 1
  /// Bounds of positions p, stored as sign(p) ln(|p| + 1), finite.
  glm::dvec3 position_low{0}, position_high{0};
  std::array<ByteTable, 3> log_scale, dc;  ///< index: axis, colour channel
  ByteTable logit;                         ///< index: alpha
  std::string positions_low, positions_high, scales, rotations, colors;  ///< file names

  int sh_bands = 0;  ///< 0 none, 1..3; -1: given by the width of `centroids` (version 1)
  std::uint64_t sh_palette = 0;  ///< rows of coefficients in `centroids`; 0: as many as fit
  ByteTable sh;
  std::string centroids, labels;
};

/// `source` names the file in messages. Throws Error(input).
SogMeta parse_sog_meta(std::string_view text, const std::string& source);

class SogDecoder {
 public:
  /// `meta` is the text of meta.json, `source` its name in messages, `folder` the prefix of its
  /// pictures' names in `files`. Throws Error(input).
  SogDecoder(std::string_view meta, const std::string& source, FileSource& files,
             const std::string& folder, ThreadPool& pool);

  int version() const { return meta_.version; }
  const std::string& model() const { return meta_.model; }
  std::uint64_t count() const { return meta_.count; }
  int sh_degree() const { return degree_; }
  std::uint64_t picture_bytes() const { return picture_bytes_; }

  /// Writes Gaussian `from` of this scene to position `to` of the cloud, whose degree is at least
  /// as high. May be called from several threads.
  void fill(std::uint64_t from, GaussianCloud& cloud, std::size_t to);

  /// Gaussians so far without a valid rotation, and with an SH label out of range.
  std::size_t unrotated() const { return unrotated_; }
  std::size_t unlabelled() const { return unlabelled_; }

 private:
  using Pixels = Array<std::uint8_t>;

  SogMeta meta_;
  Pixels positions_low_, positions_high_, scales_, rotations_, colors_, centroids_, labels_;
  std::uint64_t centroid_columns_ = 0;  // texels in a row
  std::uint64_t palette_ = 0;
  int degree_ = 0;
  std::uint64_t picture_bytes_ = 0;
  std::atomic<std::size_t> unrotated_ = 0, unlabelled_ = 0;
};

}  // namespace qs
