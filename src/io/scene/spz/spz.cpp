// SPDX-License-Identifier: MIT
#include "io/scene/spz/spz.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <new>
#include <ostream>
#include <string>
#include <utility>
#include <vector>

#include <glm/gtc/packing.hpp>
#include <zstd.h>

#include "base/fail.h"
#include "base/rank.h"
#include "io/bytes/byte_cursor.h"
#include "io/bytes/byte_text.h"
#include "io/bytes/inflate.h"
#include "io/bytes/replace_file.h"
#include "io/cloud/axes.h"
#include "io/cloud/cloud_memory.h"
#include "io/cloud/fill_cloud.h"
#include "io/cloud/lod_tree.h"
#include "io/cloud/quantised.h"
#include "io/cloud/scene.h"
#include "io/scene/ply/ply.h"
#include "io/scene/spz/spz_container.h"
#include "raster/scene/activated_cloud.h"

namespace qs {
namespace {

// Index in kAxes of the frame in the extension records. A record is a type, a length and that
// number of bytes; unknown records are skipped. Frames above 8 exchange axes; no known writer uses
// them.
constexpr std::size_t kRub = 3;

std::size_t stored_frame(SpzContent& content) {
  constexpr std::uint32_t kCoordinateSystem = 0xADBE0003;
  constexpr std::uint64_t kRecordHeader = 8;
  if ((content.header.flags & SpzHeader::kExtensions) == 0) return kRub;
  ByteSpan rest = content.extensions;
  do {
    const std::uint64_t length =
        rest.size() < kRecordHeader ? rest.size() : load<std::uint32_t>(rest.data() + 4);
    if (kRecordHeader + length > rest.size()) {
      content.warnings.push_back("The .spz extensions are damaged and were ignored.");
      break;
    }
    if (load<std::uint32_t>(rest.data()) == kCoordinateSystem && length == 4) {
      const auto number = load<std::uint32_t>(rest.data() + kRecordHeader);
      if (number >= 1 && number <= kAxes.size()) return number - 1;
      content.warnings.push_back(
          fmt::format("Coordinate system {} is not supported; RUB was assumed.", number));
      break;
    }
    rest = rest.subspan(kRecordHeader + length);
  } while (!rest.empty());
  return kRub;
}

// Signed 24-bit little-endian.
float fixed_point(const std::byte* at, float step) {
  const auto bits = load<std::uint16_t>(at) | static_cast<std::uint32_t>(at[2]) << 16;
  return static_cast<float>(static_cast<std::int32_t>(bits << 8) >> 8) * step;
}

// Versions 1 and 2: x, y, z as bytes, w >= 0.
glm::quat rotation_of_bytes(const std::byte* at) {
  const auto component = [&](int i) { return static_cast<double>(at[i]) / 127.5 - 1; };
  const auto q = restore_largest({component(0), component(1), component(2)}, 3);
  return make_quat(q[3], q[0], q[1], q[2]);
}

// Version 3 and later: index of the largest of x, y, z, w, then three times sign and magnitude.
glm::quat rotation_of_bits(std::uint32_t bits) {
  const auto component = [&](int shift) {
    const double magnitude = (bits >> shift & 511) / 511.0 * std::sqrt(0.5);
    return (bits >> shift & 512) != 0 ? -magnitude : magnitude;
  };
  const auto q = restore_largest({component(20), component(10), component(0)}, bits >> 30);
  return make_quat(q[3], q[0], q[1], q[2]);
}

// In a tree of levels of detail 255 stands for an opacity of 2. The opacity 1 is rounded up to 128.
constexpr double kOneInTree = 127.5;
constexpr std::byte kRoundedOne{128};

bool has_tree(const SpzHeader& header) { return (header.flags & SpzHeader::kLodTree) != 0; }

LodTree read_tree(const SpzContent& content, const std::string& path) {
  const ByteSpan counts = content.blocks[kSpzChildCounts], starts = content.blocks[kSpzChildStarts];
  const auto children_of = [&](std::size_t i) {
    return LodChildren{load<std::uint32_t>(&starts[4 * i]), load<std::uint16_t>(&counts[2 * i])};
  };
  return read_lod_tree(content.header.count, children_of, path);
}

// The decoded value of each byte.
struct ByteTables {
  std::array<float, 256> logit, dc, log_scale, sh;

  // `highest_opacity`: the byte that stands for 1.
  explicit ByteTables(double highest_opacity) {
    for (std::size_t i = 0; i < 256; ++i) {
      const auto byte = static_cast<double>(i);
      logit[i] = logit_of_byte(static_cast<std::uint8_t>(i), highest_opacity);
      dc[i] = static_cast<float>((byte / 255 - 0.5) / 0.15);
      log_scale[i] = static_cast<float>(byte / 16 - 10);
      sh[i] = static_cast<float>((byte - 128) / 128);
    }
  }
};

class SpzDecoder {
 public:
  SpzDecoder(const SpzContent& content, GaussianCloud& cloud)
      : content_(content),
        cloud_(cloud),
        row_bytes_(spz_row_bytes(content.header)),
        step_(std::ldexp(1.0f, -content.header.fractional_bits)),
        tables_(has_tree(content.header) ? kOneInTree : 255) {}

  /// Decodes Gaussian `i` of the file. `k`: its index in the cloud.
  void fill(std::size_t i, std::size_t k) const {
    cloud_.positions[k] = position(row(kSpzPositions, i));
    cloud_.opacity_logits[k] = tables_.logit[byte(row(kSpzAlphas, i), 0)];
    cloud_.log_scales[k] = triple(tables_.log_scale, row(kSpzScales, i));
    const std::byte* const rotation = row(kSpzRotations, i);
    cloud_.rotations[k] = content_.header.version <= 2
                              ? rotation_of_bytes(rotation)
                              : rotation_of_bits(load<std::uint32_t>(rotation));
    glm::vec3* const sh = sh_of(cloud_, k);
    sh[0] = triple(tables_.dc, row(kSpzColors, i));
    const std::byte* const rest = row(kSpzSh, i);
    const std::size_t coefficients = sh_count(cloud_);
    for (std::size_t c = 1; c < coefficients; ++c) sh[c] = triple(tables_.sh, rest + 3 * (c - 1));
  }

 private:
  const std::byte* row(SpzBlock block, std::size_t i) const {
    return content_.blocks[block].data() + i * row_bytes_[block];
  }
  static std::size_t byte(const std::byte* at, std::size_t i) {
    return static_cast<std::size_t>(at[i]);
  }
  static glm::vec3 triple(const std::array<float, 256>& table, const std::byte* at) {
    return {table[byte(at, 0)], table[byte(at, 1)], table[byte(at, 2)]};
  }
  glm::vec3 position(const std::byte* at) const {
    if (content_.header.version == 1)
      return {glm::unpackHalf1x16(load<std::uint16_t>(at)),
              glm::unpackHalf1x16(load<std::uint16_t>(at + 2)),
              glm::unpackHalf1x16(load<std::uint16_t>(at + 4))};
    return {fixed_point(at, step_), fixed_point(at + 3, step_), fixed_point(at + 6, step_)};
  }

  const SpzContent& content_;
  GaussianCloud& cloud_;
  std::array<std::uint64_t, kSpzBlocks> row_bytes_;
  float step_;  // world units
  ByteTables tables_;
};

void describe(const SpzHeader& header, std::size_t frame, Scene& scene) {
  scene.axes = kAxes[frame];
  scene.format = fmt::format("spz, version {}{}", header.version,
                             has_tree(header) ? ", levels of detail" : "");
  scene.cloud.antialiased = (header.flags & SpzHeader::kAntialiased) != 0;
}

// The sample of content whose SH are not unpacked yet.
SceneSample sample_of(const SpzContent& content, const Scene& scene, ThreadPool& pool,
                      const Sampling& sampling) {
  SceneSample sample = make_sample(scene, content.header.count, sampling);
  describe(content.header, kRub, sample.scene);
  const SpzDecoder decoder(content, sample.scene.cloud);
  fill_cloud(sample.scene, pool, {}, 0, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) decoder.fill(k * sample.step, k);
    flip_axes(sample.scene.cloud, begin, end, signs_to_rdf(kRub));
  });
  sample.scene.warnings.clear();
  return sample;
}

using Bytes = std::vector<std::uint8_t>;
using Blocks = std::array<Bytes, kSpzSh + 1>;

constexpr int kMaxFixedPoint = (1 << 23) - 1;

float largest_coordinate(const glm::vec3& p) {
  return std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)});
}

// The largest number of fractional bits, up to Niantic's 12, with which the positions of 99.9 % of
// the Gaussians fit 24 bits.
int fractional_bits(const GaussianCloud& cloud, const std::string& path) {
  std::vector<float> sizes(cloud.size());
  std::ranges::transform(cloud.positions, sizes.begin(), largest_coordinate);
  const std::size_t strays = cloud.size() / 1000;
  const float largest = sizes.empty() ? 0 : at_rank(sizes, sizes.size() - 1 - strays);
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
    const double exact = std::ldexp(static_cast<double>(position[axis]), bits);
    const auto fixed = static_cast<std::int32_t>(
        std::lround(std::clamp<double>(exact, -kMaxFixedPoint, kMaxFixedPoint)));
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

// Damaged gzip data is recognised by the extension, so that the reader's message names the defect.
bool recognises_spz(ByteSpan content, const std::filesystem::path& path) {
  return is_spz(content) || (is_gzip(content) && path.extension() == ".spz");
}

void read_spz(ByteSpan content, const std::filesystem::path& path, ThreadPool& pool,
              const ReadOptions& options, Scene& scene) {
  constexpr float kUnpacked = 0.5f;  // share of the progress
  const auto take_sample = [&](const SpzContent& base) {
    // Extensions, which may declare other axes, come last, and so do trees.
    const bool is_sound = (base.header.flags & (SpzHeader::kExtensions | SpzHeader::kLodTree)) == 0;
    if (!is_sound || !is_sampled(base.header.count, options.sampling)) return;
    try {
      options.sampling.take(sample_of(base, scene, pool, options.sampling));
      // no Gaussian of the sample can be drawn; the other Gaussians may be drawable
    } catch (const Error&) {
    }
  };
  SpzContent spz = unpack_spz(content, path, pool, options.progress, kUnpacked, take_sample);
  const std::size_t frame = stored_frame(spz);
  const AxisSigns signs = signs_to_rdf(frame);
  scene.warnings = std::move(spz.warnings);

  LodTree tree;
  const bool is_tree = has_tree(spz.header);
  if (is_tree) {
    tree = read_tree(spz, path.string());
    scene.levels = {tree.levels, spz.header.count, tree.leaves.size(),
                    spz.header.count - tree.leaves.size()};
    const auto above_1 = std::ranges::count_if(tree.leaves, [&](std::uint32_t leaf) {
      return spz.blocks[kSpzAlphas][leaf] > kRoundedOne;
    });
    if (above_1 > 0) scene.warn("{} leaves have an opacity above 1, which was clamped.", above_1);
  }

  scene.cloud = make_cloud(is_tree ? tree.leaves.size() : spz.header.count,
                           kept_sh_degree(sh_coefficient_count(spz.header.sh_degree) - 1, scene));
  describe(spz.header, frame, scene);

  const SpzDecoder decoder(spz, scene.cloud);
  fill_cloud(scene, pool, options.progress, kUnpacked, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) decoder.fill(is_tree ? tree.leaves[i] : i, i);
    flip_axes(scene.cloud, begin, end, signs);
  });
}

std::string loss_in_spz(const GaussianCloud& cloud) {
  const int bits = fractional_bits(cloud, "");
  const double range = std::ldexp(kMaxFixedPoint, -bits);
  const auto strays = std::ranges::count_if(cloud.positions, [&](const glm::vec3& p) {
    return static_cast<double>(largest_coordinate(p)) > range;
  });
  std::string text;
  if (bits < 12) text = fmt::format("positions are in steps of {:g}", std::ldexp(1.0, -bits));
  if (strays > 0)
    text += fmt::format("{}{} Gaussian{} beyond {:.0f} moved to the border; --crop leaves them out",
                        text.empty() ? "" : "; ", strays, strays == 1 ? "" : "s", range);
  return text;
}

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
  const std::size_t streams = cloud.sh_degree == 0 ? blocks.size() - 1 : blocks.size();
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
