// SPDX-License-Identifier: MIT
#include "io/scene/splat/splat.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <ostream>
#include <string>
#include <vector>

#include <glm/gtc/packing.hpp>

#include "io/bytes/byte_cursor.h"
#include "io/bytes/byte_text.h"
#include "io/bytes/replace_file.h"
#include "io/cloud/cloud_memory.h"
#include "io/cloud/fill_cloud.h"
#include "io/cloud/quantised.h"
#include "raster/kernel/constants.h"
#include "raster/scene/activated_cloud.h"
#include "raster/scene/cloud_order.h"

namespace qs {
namespace {

constexpr std::size_t kRowBytes = 32;
constexpr std::size_t kScale = 12, kColor = 24, kOpacity = 27, kRotation = 28;

glm::vec3 vector(const std::byte* at) {
  return {load<float>(at), load<float>(at + 4), load<float>(at + 8)};
}

int component(const std::byte* row, std::size_t i) {
  return static_cast<int>(row[kRotation + i]) - 128;
}

int rotation_square(const std::byte* row) {
  int square = 0;
  for (std::size_t i = 0; i < 4; ++i) square += component(row, i) * component(row, i);
  return square;
}

// Other data rarely looks like a unit quaternion after finite floats.
bool is_plausible(const std::byte* row) {
  constexpr float kMaxPosition = 1e9f, kMaxScale = 1e6f;
  for (int axis = 0; axis < 3; ++axis) {
    if (!(std::abs(vector(row)[axis]) < kMaxPosition)) return false;
    if (!(vector(row + kScale)[axis] >= 0 && vector(row + kScale)[axis] < kMaxScale)) return false;
  }
  const double length = std::sqrt(rotation_square(row)) / 128;
  return length > 0.95 && length < 1.05;
}

using Row = std::array<std::uint8_t, kRowBytes>;

Row row_of(const GaussianCloud& cloud, std::size_t i) {
  Row row;
  const glm::vec3 scale = glm::exp(cloud.log_scales[i]);
  std::memcpy(row.data(), &cloud.positions[i], 12);
  std::memcpy(row.data() + kScale, &scale, 12);
  const glm::vec3& dc = *sh_of(cloud, i);
  for (std::size_t c = 0; c < 3; ++c) {
    const double color = 0.5 + kSh0 * static_cast<double>(dc[static_cast<int>(c)]);
    row[kColor + c] = static_cast<std::uint8_t>(round_to_integer(color * 255, 255));
  }
  row[kOpacity] = static_cast<std::uint8_t>(
      round_to_integer(opacity_of_logit(cloud.opacity_logits[i]) * 255, 255));
  const glm::quat& q = cloud.rotations[i];
  std::size_t at = kRotation;
  for (const float component : {q.w, q.x, q.y, q.z})
    row[at++] = static_cast<std::uint8_t>(round_to_integer(component * 128.0 + 128, 255));
  return row;
}

constexpr std::size_t kHeaderBytes = 4096, kSectionHeaderBytes = 1024;
constexpr std::size_t kBucketBytes = 12;
constexpr int kMaxDegree = 2, kMaxLevel = 2;

// The header and the header of a section, as they are stored.
struct Header {
  std::uint8_t major, minor;
  std::uint32_t max_sections, sections, max_count, count;
  std::uint16_t level;
  std::uint8_t unused[14];
  float min_sh, max_sh;  // range of the SH values of level 2
};
static_assert(offsetof(Header, max_sections) == 4 && offsetof(Header, min_sh) == 36);
struct SectionHeader {
  std::uint32_t count, max_count, bucket_size, buckets;
  float block_size;
  std::uint16_t bucket_bytes;
  std::uint32_t range, bytes, full_buckets, partial_buckets;
  std::uint16_t degree;
};
static_assert(offsetof(SectionHeader, range) == 24 && offsetof(SectionHeader, degree) == 40);
Header parse_header(ByteSpan bytes) {
  auto header = load<Header>(bytes.data());
  if (header.min_sh == 0) header.min_sh = -1.5f;
  if (header.max_sh == 0) header.max_sh = 1.5f;
  return header;
}

// Offsets in a row, by compression level.
struct RowLayout {
  std::size_t scale, rotation, color, sh, sh_value_bytes;
};
constexpr RowLayout kLayouts[] = {{12, 24, 40, 44, 4}, {6, 12, 20, 24, 2}, {6, 12, 20, 24, 1}};

struct Section {
  std::uint64_t count = 0;  // Gaussians
  int degree = 0;
  std::uint64_t row_bytes = 0;
  ByteSpan rows;
  // Positions of levels 1 and 2 are relative to buckets: first full buckets, then partial buckets
  // with fewer rows.
  std::uint64_t bucket_size = 1, full_buckets = 0;
  std::vector<std::uint64_t> partial_ends;  // end row of each partial bucket
  ByteSpan centers;
  float step = 0, range = 0;

  glm::vec3 bucket_center(std::uint64_t row) const {
    std::uint64_t bucket = row / bucket_size;
    if (bucket >= full_buckets) {
      const auto end = std::ranges::upper_bound(partial_ends, row);
      bucket = full_buckets + static_cast<std::uint64_t>(end - partial_ends.begin());
    }
    const std::byte* const at = centers.data() + bucket * kBucketBytes;
    return {load<float>(at), load<float>(at + 4), load<float>(at + 8)};
  }
};

class KsplatFile {
 public:
  KsplatFile(ByteSpan content, std::string path) : path_(std::move(path)), cursor_(content, path_) {
    header_ = parse_header(cursor_.take(kHeaderBytes, "the header"));
    check_header();
    const auto headers =
        cursor_.take(header_.max_sections * kSectionHeaderBytes, "section headers");
    for (std::uint32_t i = 0; i < header_.sections; ++i) {
      const auto* const at = headers.data() + i * kSectionHeaderBytes;
      sections_.push_back(parse_section(load<SectionHeader>(at)));
      parts_.add(sections_.back().count);
    }
    const std::uint64_t count = parts_.count();
    if (count != header_.count)
      fail("{}: the header announces {} Gaussians, its sections {}", path_, header_.count, count);
    if (count == 0) fail("{}: holds no Gaussians", path_);
    if (count > header_.max_count)
      fail("{}: the header announces room for {} Gaussians, there are {}", path_, header_.max_count,
           count);
  }

  const Header& header() const { return header_; }
  std::size_t count() const { return header_.count; }
  std::uint64_t bytes_left() const { return cursor_.left(); }

  int degree() const {
    int degree = 0;
    for (const Section& section : sections_) degree = std::max(degree, section.degree);
    return degree;
  }

  void fill(GaussianCloud& cloud, std::size_t begin, std::size_t end) const {
    parts_.for_range(begin, end, [&](std::size_t part, std::uint64_t row, std::size_t i) {
      fill_row(sections_[part], row, cloud, i);
    });
  }

 private:
  void check_header() const {
    if (header_.major != 0 || header_.minor != 1)
      fail("{}: .ksplat version {}.{}, only 0.1 exists", path_, header_.major, header_.minor);
    if (header_.level > kMaxLevel)
      fail("{}: compression level {}, 0 to {} exist", path_, header_.level, kMaxLevel);
    if (header_.sections > header_.max_sections)
      fail("{}: {} sections where there is room for {}", path_, header_.sections,
           header_.max_sections);
    if (!std::isfinite(header_.min_sh) || !std::isfinite(header_.max_sh))
      fail("{}: the range of its SH values is not finite", path_);
  }

  Section parse_section(const SectionHeader& stored) {
    Section section;
    section.count = stored.count;
    section.bucket_size = stored.bucket_size;
    section.full_buckets = stored.full_buckets;
    section.degree = stored.degree;
    const std::uint64_t buckets = stored.buckets, partial_buckets = stored.partial_buckets;
    // Check the numbers.
    if (stored.degree > kMaxDegree)
      fail("{}: SH degree {} does not exist in .ksplat", path_, stored.degree);
    if (stored.count > stored.max_count)
      fail("{}: a section has {} Gaussians and room for {}", path_, stored.count, stored.max_count);
    const std::uint64_t begin = cursor_.offset();
    const RowLayout& layout = kLayouts[header_.level];
    const auto rest = static_cast<std::size_t>(sh_coefficient_count(section.degree) - 1);
    section.row_bytes = layout.sh + 3 * rest * layout.sh_value_bytes;
    // Compressed positions are relative to the centres of buckets.
    if (header_.level > 0) {
      // A section without Gaussians may leave the other fields at 0.
      if (stored.count > 0 && (stored.bucket_size == 0 || stored.bucket_bytes != kBucketBytes))
        fail("{}: a section has buckets of {} rows and {} bytes", path_, stored.bucket_size,
             stored.bucket_bytes);
      if (section.full_buckets + partial_buckets > buckets)
        fail("{}: a section uses {} buckets and has {}", path_,
             section.full_buckets + partial_buckets, buckets);
      const auto lengths = cursor_.take(4 * partial_buckets, "the lengths of buckets");
      section.centers = cursor_.take(kBucketBytes * buckets, "the centres of buckets");
      std::uint64_t end = section.full_buckets * section.bucket_size;  // both below 2^32
      for (std::uint64_t i = 0; i < partial_buckets; ++i) {
        const auto rows = load<std::uint32_t>(lengths.data() + 4 * i);
        if (rows > section.bucket_size)
          fail("{}: a bucket of a section holds {} Gaussians and has room for {}", path_, rows,
               section.bucket_size);
        end += rows;
        section.partial_ends.push_back(end);
      }
      if (end != section.count)
        fail("{}: the buckets of a section hold {} of its {} Gaussians", path_, end, section.count);
      section.range = static_cast<float>(stored.range == 0 ? 32767 : stored.range);
      section.step = stored.block_size / 2 / section.range;
    }
    // Below 2^32 * 140.
    section.rows = cursor_.take(section.row_bytes * stored.max_count, "a section");
    const std::uint64_t bytes = cursor_.offset() - begin;
    // The field has 32 bits; old files have 0.
    if (stored.bytes != 0 && stored.bytes != static_cast<std::uint32_t>(bytes))
      fail("{}: a section announces {} bytes, its parts have {}", path_, stored.bytes, bytes);
    return section;
  }

  float number(const std::byte* at, std::size_t i) const {
    return header_.level == 0 ? load<float>(at + 4 * i)
                              : glm::unpackHalf1x16(load<std::uint16_t>(at + 2 * i));
  }

  float sh_value(const std::byte* at, std::size_t i) const {
    if (header_.level < 2) return number(at, i);
    const auto t = static_cast<float>(at[i]) / 255;
    return header_.min_sh + (header_.max_sh - header_.min_sh) * t;
  }

  void fill_row(const Section& section, std::uint64_t row, GaussianCloud& cloud,
                std::size_t i) const {
    const RowLayout& layout = kLayouts[header_.level];
    const std::byte* const at = section.rows.data() + row * section.row_bytes;
    glm::vec3& position = cloud.positions[i];
    if (header_.level == 0) {
      position = {number(at, 0), number(at, 1), number(at, 2)};
    } else {
      position = section.bucket_center(row);
      for (int axis = 0; axis < 3; ++axis) {
        const auto value = static_cast<float>(load<std::uint16_t>(at + 2 * axis));
        position[axis] += (value - section.range) * section.step;
      }
    }
    const std::byte* const scale = at + layout.scale;
    cloud.log_scales[i] = glm::log(glm::vec3(number(scale, 0), number(scale, 1), number(scale, 2)));
    const std::byte* const q = at + layout.rotation;
    cloud.rotations[i] = glm::quat(number(q, 0), number(q, 1), number(q, 2), number(q, 3));
    const std::byte* const color = at + layout.color;
    cloud.opacity_logits[i] = logit_of_byte(static_cast<std::uint8_t>(color[3]));

    glm::vec3* const sh = sh_of(cloud, i);
    std::fill_n(sh, sh_count(cloud), glm::vec3(0));
    for (int channel = 0; channel < 3; ++channel)
      sh[0][channel] = static_cast<float>((static_cast<double>(color[channel]) / 255 - 0.5) / kSh0);
    // Ordered by band, within a band by channel.
    std::size_t value = 0;
    for (std::size_t l = 1; l <= static_cast<std::size_t>(section.degree); ++l)
      for (int channel = 0; channel < 3; ++channel)
        for (std::size_t k = l * l; k < (l + 1) * (l + 1); ++k)
          sh[k][channel] = sh_value(at + layout.sh, value++);
  }

  std::string path_;
  ByteCursor cursor_;
  Header header_{};
  std::vector<Section> sections_;
  CloudParts parts_;  // the sections
};

}  // namespace

bool recognises_splat(ByteSpan content, const std::filesystem::path&) {
  constexpr std::size_t kLookedAt = 64;
  const std::size_t rows = std::min(content.size() / kRowBytes, kLookedAt);
  if (rows == 0 || content.size() % kRowBytes != 0) return false;
  for (std::size_t i = 0; i < rows; ++i)
    if (!is_plausible(content.data() + i * kRowBytes)) return false;
  return true;
}

void read_splat(ByteSpan content, const std::filesystem::path& path, ThreadPool& pool,
                const ReadOptions& options, Scene& scene) {
  const std::size_t count = content.size() / kRowBytes, rest = content.size() % kRowBytes;
  if (count == 0)
    fail("{}: cut off: {} bytes, one Gaussian needs {}", path.string(), content.size(), kRowBytes);
  if (rest != 0)
    scene.warn("The last {} bytes are no whole row of {} and were ignored.", rest, kRowBytes);
  scene.format = "splat";
  scene.cloud = make_cloud(count, 0);
  GaussianCloud& cloud = scene.cloud;
  std::atomic<std::size_t> unrotated = 0;

  const auto fill = [&](std::size_t i) {
    const std::byte* const row = content.data() + i * kRowBytes;
    cloud.positions[i] = vector(row);
    cloud.log_scales[i] = glm::log(vector(row + kScale));
    for (int c = 0; c < 3; ++c) {
      const auto byte = static_cast<double>(row[kColor + static_cast<std::size_t>(c)]);
      cloud.sh[i][c] = static_cast<float>((byte / 255 - 0.5) / kSh0);
    }
    cloud.opacity_logits[i] = logit_of_byte(static_cast<std::uint8_t>(row[kOpacity]));
    if (rotation_square(row) == 0) {
      cloud.rotations[i] = make_quat(1, 0, 0, 0);
      ++unrotated;
    } else {
      cloud.rotations[i] =
          make_quat(component(row, 0), component(row, 1), component(row, 2), component(row, 3));
    }
  };
  fill_cloud(scene, pool, options.progress, 0, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) fill(i);
  });
  if (unrotated > 0) warn_of_missing_rotations(scene, unrotated);
}

void write_splat(const GaussianCloud& cloud, const std::filesystem::path& path, ThreadPool&,
                 const Progress& progress) {
  constexpr std::size_t kRowsPerWrite = 1 << 15;
  const auto order = largest_first(cloud);
  write_file(path, [&](std::ostream& file) {
    std::vector<Row> rows;
    for (std::size_t i = 0; i < order.size(); ++i) {
      rows.push_back(row_of(cloud, order[i]));
      if (rows.size() < kRowsPerWrite && i + 1 < order.size()) continue;
      write_values(file, rows);
      rows.clear();
      progress.update(static_cast<float>(i + 1) / static_cast<float>(order.size()));
    }
  });
}

bool recognises_ksplat(ByteSpan content, const std::filesystem::path&) {
  if (content.size() < kHeaderBytes + kSectionHeaderBytes) return false;
  const Header header = parse_header(content);
  return header.major == 0 && header.minor == 1 && header.level <= kMaxLevel &&
         header.sections > 0 && header.sections <= header.max_sections &&
         fits(header.max_sections, kSectionHeaderBytes, content.size()) && header.count > 0;
}

void read_ksplat(ByteSpan content, const std::filesystem::path& path, ThreadPool& pool,
                 const ReadOptions& options, Scene& scene) {
  const KsplatFile file(content, path.string());
  scene.format = fmt::format("ksplat, level {}", file.header().level);
  scene.cloud = make_cloud(file.count(), file.degree());
  fill_cloud(scene, pool, options.progress, 0,
             [&](std::size_t begin, std::size_t end) { file.fill(scene.cloud, begin, end); });
  if (file.bytes_left() > 0)
    scene.warn("{} bytes after the last section were ignored.", file.bytes_left());
}

}  // namespace qs
