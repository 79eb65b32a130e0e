// SPDX-License-Identifier: MIT
//
// Buckets of Gaussians on the disk: ranges of a Morton curve with about equally many Gaussians.
#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "base/parallel.h"
#include "learn/lod/section.h"
#include "raster/scene/gaussian_cloud.h"

namespace qs {

/// Gaussians at one place differ by their number among all inputs.
struct BucketKey {
  std::uint64_t code = 0, index = 0;
  auto operator<=>(const BucketKey&) const = default;
};

struct BucketRanges {
  glm::vec3 low{0};  ///< of the cube in which codes count; Gaussians outside have the nearest cell
  float side = 1;
  std::vector<BucketKey> splits;  ///< ascending; the first key of each bucket but the first

  std::uint64_t code(glm::vec3 position) const;
  std::size_t bucket(const BucketKey& key) const;
};

/// Positions and sizes at equal distances in the list of all Gaussians, at most 2 million.
class CloudSample {
 public:
  /// `first`: the number of the cloud's first Gaussian.
  void add(const GaussianCloud& cloud, std::uint64_t first);

  BucketRanges ranges(std::size_t buckets) const;

  /// A power of two of about a sixteenth of the median Gaussian's largest standard deviation.
  float footprint() const;

 private:
  struct Row {
    std::uint64_t index;
    glm::vec3 position;
    float log_size;
  };
  std::vector<Row> rows_;
  std::uint64_t step_ = 1;
};

class BucketWriter {
 public:
  /// `original`: the rows have the words of rad_original.h too. `path(i)`: the file of bucket `i`.
  BucketWriter(const BucketRanges& ranges, int sh_degree, bool original,
               std::function<std::filesystem::path(std::size_t i)> path);

  void add(const GaussianCloud& cloud, std::uint64_t first, ThreadPool& pool);

  /// Writes the rest. Throws Error(input) if the disk is full, as add().
  void finish();

 private:
  void flush(std::size_t bucket);

  const BucketRanges& ranges_;
  std::size_t sh_values_, original_words_;
  std::function<std::filesystem::path(std::size_t i)> path_;
  std::vector<std::string> waiting_;  // bytes of each bucket
};

/// The Gaussians of a bucket's file along a Morton curve. Throws Error(input).
LodItems read_bucket(const std::filesystem::path& path, int sh_degree, bool original);

}  // namespace qs
