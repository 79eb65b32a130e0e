// SPDX-License-Identifier: MIT
#include "learn/lod/bucket_files.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <numeric>

#include "base/morton.h"
#include "base/rank.h"
#include "io/bytes/byte_cursor.h"
#include "io/bytes/mapped_file.h"
#include "io/bytes/replace_file.h"
#include "io/cloud/cloud_memory.h"
#include "io/scene/rad/rad_original.h"
#include "raster/kernel/constants.h"
#include "raster/kernel/half.h"
#include "raster/scene/activated_cloud.h"

namespace qs {
namespace {

// A row of a bucket's file; the SH follow as halves, then perhaps the original values.
struct BucketRow {
  glm::vec3 position, log_scale;
  glm::quat rotation;
  float logit;
};

constexpr std::size_t values_of_degree(int degree) {
  return 3 * static_cast<std::size_t>(sh_coefficient_count(degree));
}

std::size_t bytes_of_row(std::size_t sh_values, std::size_t words) {
  return sizeof(BucketRow) + 2 * sh_values + words * sizeof(std::uint32_t);
}

}  // namespace

std::uint64_t BucketRanges::code(glm::vec3 position) const {
  const glm::vec3 at = (position - low) / side;
  const auto cell = [&](int axis) {
    return static_cast<std::uint64_t>(std::clamp(at[axis], 0.0f, 1.0f) * 2097151.0f);
  };
  return morton_code(cell(0), cell(1), cell(2));
}

std::size_t BucketRanges::bucket(const BucketKey& key) const {
  return static_cast<std::size_t>(std::ranges::upper_bound(splits, key) - splits.begin());
}

void CloudSample::add(const GaussianCloud& cloud, std::uint64_t first) {
  constexpr std::size_t kMost = 2'000'000;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if ((first + i) % step_ != 0) continue;
    const glm::vec3& s = cloud.log_scales[i];
    rows_.push_back({first + i, cloud.positions[i], std::max({s.x, s.y, s.z})});
    if (rows_.size() < kMost) continue;
    step_ *= 2;
    std::erase_if(rows_, [&](const Row& row) { return row.index % step_ != 0; });
  }
}

BucketRanges CloudSample::ranges(std::size_t buckets) const {
  BucketRanges ranges;
  ranges.side = 0;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<float> values;
    for (const Row& row : rows_) values.push_back(row.position[axis]);
    const float low = quantile(values, 0.01), high = quantile(values, 0.99);
    ranges.low[axis] = low - (high - low) / 2;
    ranges.side = std::max(ranges.side, 2 * (high - low));
  }
  ranges.side = std::max(ranges.side, 1e-20f);
  std::vector<BucketKey> keys;
  for (const Row& row : rows_) keys.push_back({ranges.code(row.position), row.index});
  std::ranges::sort(keys);
  for (std::size_t b = 1; b < std::min(buckets, keys.size()); ++b)
    ranges.splits.push_back(keys[b * keys.size() / buckets]);
  return ranges;
}

float CloudSample::footprint() const {
  std::vector<float> sizes;
  for (const Row& row : rows_) sizes.push_back(std::max(row.log_size, -60.0f));
  const float log2_size = quantile(sizes, 0.5) * static_cast<float>(kLog2E);
  return std::exp2(std::clamp(std::floor(log2_size) - 4, -40.0f, 40.0f));
}

BucketWriter::BucketWriter(const BucketRanges& ranges, int sh_degree, bool original,
                           std::function<std::filesystem::path(std::size_t i)> path)
    : ranges_(ranges),
      sh_values_(values_of_degree(sh_degree)),
      original_words_(original ? original_words(sh_degree) : 0),
      path_(std::move(path)) {
  waiting_.resize(ranges.splits.size() + 1);
}

void BucketWriter::add(const GaussianCloud& cloud, std::uint64_t first, ThreadPool& pool) {
  constexpr std::size_t kBatch = 1 << 18, kWaiting = 1 << 18;  // Gaussians, bytes
  const std::size_t row_bytes = bytes_of_row(sh_values_, original_words_);
  const std::size_t own_values = 3 * sh_count(cloud);
  std::vector<char> rows(std::min(kBatch, cloud.size()) * row_bytes);
  std::vector<std::uint32_t> buckets(std::min(kBatch, cloud.size())), order(buckets.size());
  std::vector<std::uint32_t> ends(waiting_.size() + 1);
  for (std::size_t begin = 0; begin < cloud.size(); begin += kBatch) {
    const std::size_t count = std::min(kBatch, cloud.size() - begin);
    pool.for_each(count, 4096, [&](std::size_t k) {
      const std::size_t i = begin + k;
      const BucketRow row{cloud.positions[i], cloud.log_scales[i], cloud.rotations[i],
                          cloud.opacity_logits[i]};
      std::memcpy(&rows[k * row_bytes], &row, sizeof row);
      std::array<std::uint16_t, values_of_degree(3)> halves{};
      const float* const sh = &sh_of(cloud, i)->x;
      std::transform(sh, sh + own_values, halves.begin(), nearest_half);
      std::memcpy(&rows[k * row_bytes + sizeof row], halves.data(), 2 * sh_values_);
      if (original_words_ > 0) {
        std::vector<std::uint32_t> words(original_words_);
        pack_original(cloud, i, static_cast<std::uint32_t>(first + i), words);
        std::memcpy(&rows[k * row_bytes + sizeof row + 2 * sh_values_], words.data(),
                    words.size() * sizeof words[0]);
      }
      buckets[k] =
          static_cast<std::uint32_t>(ranges_.bucket({ranges_.code(row.position), first + i}));
    });
    // Rows by bucket, so that each bucket has one thread.
    std::ranges::fill(ends, 0u);
    for (std::size_t k = 0; k < count; ++k) ++ends[buckets[k] + 1];
    std::partial_sum(ends.begin(), ends.end(), ends.begin());
    std::vector<std::uint32_t> next(ends.begin(), ends.end() - 1);
    for (std::size_t k = 0; k < count; ++k)
      order[next[buckets[k]]++] = static_cast<std::uint32_t>(k);
    pool.for_each(waiting_.size(), 1, [&](std::size_t bucket) {
      std::string& bytes = waiting_[bucket];
      for (std::uint32_t k = ends[bucket]; k < ends[bucket + 1]; ++k)
        bytes.append(&rows[order[k] * row_bytes], row_bytes);
      if (bytes.size() > kWaiting) flush(bucket);
    });
  }
}

void BucketWriter::flush(std::size_t bucket) {
  const std::filesystem::path path = path_(bucket);
  std::ofstream file(path, std::ios::binary | std::ios::app);
  file << waiting_[bucket];
  file.close();
  if (!file) fail_to_write(path, path);
  waiting_[bucket].clear();
}

void BucketWriter::finish() {
  for (std::size_t i = 0; i < waiting_.size(); ++i) flush(i);
}

LodItems read_bucket(const std::filesystem::path& path, int sh_degree, bool original) {
  const MappedFile file(path);
  const std::size_t values = values_of_degree(sh_degree);
  const std::size_t words = original ? original_words(sh_degree) : 0;
  const std::size_t row_bytes = bytes_of_row(values, words);
  const std::size_t count = file.content().size() / row_bytes;
  // Along a Morton curve: neighbours in space are near each other in memory.
  BucketRanges cube{glm::vec3(1e30f), 1e-20f, {}};
  const auto position = [&](std::size_t i) {
    return load<BucketRow>(&file.content()[i * row_bytes]).position;
  };
  glm::vec3 high(-1e30f);
  for (std::size_t i = 0; i < count; ++i) {
    cube.low = glm::min(cube.low, position(i));
    high = glm::max(high, position(i));
  }
  for (int axis = 0; axis < 3; ++axis) cube.side = std::max(cube.side, high[axis] - cube.low[axis]);
  std::vector<BucketKey> order(count);
  for (std::size_t i = 0; i < count; ++i) order[i] = {cube.code(position(i)), i};
  std::ranges::sort(order);
  GaussianCloud one;
  one.resize(1, std::min(sh_degree, 1));
  LodItems items;
  items.gaussians.reserve(count);
  items.levels.resize(count);
  items.drawn.nodes.resize(count);
  items.drawn.sh.resize(count * values);
  items.drawn.original.resize(count * words);
  for (std::size_t i = 0; i < count; ++i) {
    const std::byte* const at = &file.content()[order[i].index * row_bytes];
    const auto row = load<BucketRow>(at);
    std::uint16_t* const sh = &items.drawn.sh[i * values];
    std::memcpy(sh, at + sizeof row, 2 * values);
    if (original)
      std::memcpy(&items.drawn.original[i * words], at + sizeof row + 2 * values,
                  words * sizeof(std::uint32_t));
    for (std::size_t v = 0; v < 3 * sh_count(one); ++v)
      one.sh[v / 3][static_cast<int>(v % 3)] = float_of_half(sh[v]);
    one.positions[0] = row.position;
    one.log_scales[0] = row.log_scale;
    one.rotations[0] = row.rotation;
    one.opacity_logits[0] = row.logit;
    items.gaussians.push_back(item_of(one, 0));
    LodNode& node = items.drawn.nodes[i];
    node.center = row.position;
    node.scales = glm::exp(row.log_scale);
    node.rotation = row.rotation;
    node.alpha = items.gaussians.back().opacities;
  }
  return items;
}

}  // namespace qs
