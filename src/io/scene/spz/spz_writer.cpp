// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>
#include <cmath>
#include <new>
#include <ostream>
#include <string>
#include <vector>

#include <zstd.h>

#include "base/fail.h"
#include "io/bytes/byte_cursor.h"
#include "io/bytes/inflate.h"
#include "io/bytes/replace_file.h"
#include "io/cloud/axes.h"
#include "io/cloud/cloud_memory.h"
#include "io/cloud/quantised.h"
#include "io/scene/spz/spz.h"
#include "io/scene/spz/spz_container.h"
#include "raster/scene/activated_cloud.h"

namespace qs {
namespace {

using Bytes = std::vector<std::uint8_t>;
using Blocks = std::array<Bytes, kSpzBlocks>;

constexpr int kMaxFixedPoint = (1 << 23) - 1;

// The largest number of fractional bits, up to Niantic's 12, with which every position fits 24
// bits.
int fractional_bits(const GaussianCloud& cloud, const std::string& path) {
  float largest = 0;
  for (const glm::vec3& p : cloud.positions)
    largest = std::max({largest, std::abs(p.x), std::abs(p.y), std::abs(p.z)});
  int bits = 12;
  while (bits >= 0 && std::ldexp(static_cast<double>(largest), bits) > kMaxFixedPoint) --bits;
  if (bits < 0)
    fail("{}: .spz cannot hold positions beyond {}, there is one at {}", path, kMaxFixedPoint,
         largest);
  return bits;
}

std::uint8_t byte(double value) { return static_cast<std::uint8_t>(round_to_integer(value, 255)); }

void put_position(const glm::vec3& position, int bits, Bytes& out) {
  for (int axis = 0; axis < 3; ++axis) {
    const auto fixed = static_cast<std::int32_t>(
        std::lround(std::ldexp(static_cast<double>(position[axis]), bits)));
    for (const int shift : {0, 8, 16}) out.push_back(static_cast<std::uint8_t>(fixed >> shift));
  }
}

// Index of the largest of x, y, z, w, then three times sign and 9 bits of magnitude.
void put_rotation(const glm::quat& q, Bytes& out) {
  const SmallestThree three = drop_largest({q.x, q.y, q.z, q.w});
  std::uint32_t packed = three.dropped;
  for (const double value : three.others)
    packed = packed << 10 | (value < 0 ? 512u : 0u) |
             round_to_integer(std::abs(value) * std::sqrt(2.0) * 511, 511);
  for (const int shift : {0, 8, 16, 24}) out.push_back(static_cast<std::uint8_t>(packed >> shift));
}

// Rounds to multiples of `step` from 0, because few distinct bytes compress well. 128 stands for 0.
std::uint8_t sh_byte(float value, int step) {
  const int exact = static_cast<int>(std::lround(std::clamp(value, -2.0f, 2.0f) * 128)) + 128;
  return static_cast<std::uint8_t>(std::clamp((exact + step / 2) / step * step, 0, 255));
}

Blocks make_blocks(const GaussianCloud& cloud, int bits, const Progress& progress) {
  constexpr std::size_t kStep = 1 << 14;
  Blocks blocks;
  const std::size_t coefficients = sh_count(cloud);
  for (std::size_t first = 0; first < cloud.size(); first += kStep) {
    progress.update(0.5f * static_cast<float>(first) / static_cast<float>(cloud.size()));
    // Converts to RUB in parts, to save memory.
    const std::size_t count = std::min(kStep, cloud.size() - first);
    GaussianCloud part;
    part.resize(count, cloud.sh_degree);
    std::copy_n(&cloud.positions[first], count, part.positions.begin());
    std::copy_n(&cloud.rotations[first], count, part.rotations.begin());
    std::copy_n(&cloud.sh[first * coefficients], count * coefficients, part.sh.begin());
    flip_axes(part, 0, count, kTurnAboutX);
    for (std::size_t i = 0; i < count; ++i) {
      put_position(part.positions[i], bits, blocks[kSpzPositions]);
      put_rotation(part.rotations[i], blocks[kSpzRotations]);
      blocks[kSpzAlphas].push_back(byte(opacity_of_logit(cloud.opacity_logits[first + i]) * 255));
      const glm::vec3* const sh = &part.sh[i * coefficients];
      for (int c = 0; c < 3; ++c) {
        blocks[kSpzColors].push_back(byte((sh[0][c] * 0.15 + 0.5) * 255));
        blocks[kSpzScales].push_back(byte((cloud.log_scales[first + i][c] + 10.0) * 16));
      }
      for (std::size_t k = 1; k < coefficients; ++k)
        for (int c = 0; c < 3; ++c) blocks[kSpzSh].push_back(sh_byte(sh[k][c], k < 4 ? 8 : 16));
    }
  }
  return blocks;
}

// The fields from magic to flags are the same in every version.
std::string start_of_header(const GaussianCloud& cloud, std::uint32_t version, int bits) {
  std::string header;
  put_values(header, kSpzMagic, version, static_cast<std::uint32_t>(cloud.size()),
             static_cast<std::uint8_t>(cloud.sh_degree), static_cast<std::uint8_t>(bits),
             cloud.antialiased ? SpzHeader::kAntialiased : std::uint8_t{0});
  return header;
}

}  // namespace

void write_spz(const GaussianCloud& cloud, const std::filesystem::path& path, ThreadPool&,
               const Progress& progress) {
  constexpr int kMemory = 9;
  const int bits = fractional_bits(cloud, path.string());
  const Blocks blocks = make_blocks(cloud, bits, progress);
  std::string header = start_of_header(cloud, 3, bits);
  put_values(header, std::uint8_t{0});  // reserved
  write_file(path, [&](std::ostream& file) {
    Deflater deflater(DeflateForm::gzip, Z_DEFAULT_COMPRESSION, kMemory,
                      [&](std::string_view packed) { file << packed; });
    deflater.write(header);
    float done = 0.5f;
    for (const Bytes& block : blocks) {
      progress.update(done += 0.08f);
      deflater.write({reinterpret_cast<const char*>(block.data()), block.size()});
    }
    deflater.finish();
  });
  progress.update(1);
}

void write_spz_v4(const GaussianCloud& cloud, const std::filesystem::path& path, ThreadPool&,
                  const Progress& progress) {
  constexpr int kLevel = 9;
  const int bits = fractional_bits(cloud, path.string());
  const Blocks blocks = make_blocks(cloud, bits, progress);
  const std::size_t streams = cloud.sh_degree == 0 ? kSpzSh : kSpzBlocks;
  std::string header = start_of_header(cloud, 4, bits);
  // The offset of the table of streams follows their number.
  put_values(header, static_cast<std::uint8_t>(streams), kSpzHeaderBytes);
  header.resize(kSpzHeaderBytes);
  std::vector<Bytes> packed(streams);
  float done = 0.5f;
  for (std::size_t i = 0; i < streams; ++i) {
    progress.update(done += 0.08f);
    packed[i].resize(ZSTD_compressBound(blocks[i].size()));
    const std::size_t bytes = ZSTD_compress(packed[i].data(), packed[i].size(), blocks[i].data(),
                                            blocks[i].size(), kLevel);
    if (ZSTD_isError(bytes) != 0) throw std::bad_alloc();
    packed[i].resize(bytes);
    put_values(header, std::uint64_t{bytes}, std::uint64_t{blocks[i].size()});
  }
  write_file(path, [&](std::ostream& file) {
    file << header;
    for (const Bytes& stream : packed) write_values(file, stream);
  });
  progress.update(1);
}

}  // namespace qs
