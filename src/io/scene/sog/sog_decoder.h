// SPDX-License-Identifier: MIT
//
// One SOG scene in memory: its decoded pictures, and the conversion of their texels into Gaussians.
// Before anything is decoded, each picture's size is read from its header and checked against the
// number of Gaussians, and the number of Gaussians against the bytes of all pictures.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <string>

#include "base/parallel.h"
#include "io/bytes/file_source.h"
#include "io/scene/sog/sog_meta.h"
#include "raster/scene/gaussian_cloud.h"

namespace qs {

class SogDecoder {
 public:
  /// `meta` is the text of meta.json, `source` its name in messages, `folder` the prefix of its
  /// pictures' names in `files`. Throws Error(input).
  SogDecoder(std::string_view meta, const std::string& source, FileSource& files,
             const std::string& folder, ThreadPool& pool);

  int version() const { return meta_.version; }
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

  const std::uint8_t* coefficients_of(std::uint64_t label) const;

  SogMeta meta_;
  Pixels positions_low_, positions_high_, scales_, rotations_, colors_, centroids_, labels_;
  std::uint64_t centroid_columns_ = 0;  // texels in a row
  std::uint64_t palette_ = 0;
  int degree_ = 0;
  std::uint64_t picture_bytes_ = 0;
  std::atomic<std::size_t> unrotated_ = 0, unlabelled_ = 0;
};

}  // namespace qs
