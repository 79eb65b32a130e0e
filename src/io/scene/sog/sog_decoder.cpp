// SPDX-License-Identifier: MIT
#include "io/scene/sog/sog_decoder.h"

#include <array>
#include <cmath>
#include <vector>

#include "io/bytes/byte_cursor.h"
#include "io/bytes/json_text.h"
#include "io/bytes/json_value.h"
#include "io/cloud/cloud_memory.h"
#include "io/cloud/quantised.h"
#include "io/picture/webp_image.h"

namespace qs {

namespace {

// Real scenes need 5 bytes or more per Gaussian, but pictures of one colour could claim millions.
constexpr std::uint64_t kMaxGaussiansPerByte = 8;
// A picture is a rectangle, so it has a few more texels than there are Gaussians.
constexpr std::uint64_t kSpareTexels = 65536;
constexpr std::uint64_t kCentroidsPerRow = 64, kMaxCentroidTexels = 1024 * 960;

// Upper bound: lossless WebP of noise is little larger than the pixels.
constexpr std::uint64_t packed_bytes(std::uint64_t texels) { return 5 * texels + 65536; }

struct Picture {
  std::string name;
  std::uint64_t max_texels;
  Array<std::uint8_t>* pixels;
  Array<std::byte> packed{};
};

double from_log(double value) { return std::copysign(std::expm1(std::abs(value)), value); }

using json = nlohmann::json;

// Largest count that is exact as a double and far from overflow.
constexpr double kMaxCount = 1e12;

std::uint64_t whole_number(const json& value, const char* key, const std::string& where) {
  if (!value.is_number()) fail("{}: {} is not a number", where, key);
  const auto number = value.get<double>();
  if (!(number >= 1 && number <= kMaxCount && number == std::floor(number)))
    fail("{}: {} is {}, but must be a whole number from 1 up", where, key, number);
  return static_cast<std::uint64_t>(number);
}

const std::string& file_name(const JsonEntry& part, std::size_t index, std::size_t count) {
  const json& files = part.get("files");
  if (!files.is_array() || files.size() != count || !files[index].is_string())
    fail("{}: files is not a list of {} names", part.where, count);
  return files[index].get_ref<const std::string&>();
}

ByteTable codebook(const JsonEntry& part) {
  const json& list = part.get("codebook");
  ByteTable table;
  if (!list.is_array() || list.size() != table.size())
    fail("{}: codebook is not a list of {} numbers", part.where, table.size());
  for (std::size_t i = 0; i < table.size(); ++i)
    table[i] = static_cast<float>(part.number(list[i], "codebook"));
  return table;
}

// The number of Gaussians of a part of version 1.
std::uint64_t shape_of(const JsonEntry& part) {
  const json& shape = part.get("shape");
  if (!shape.is_array() || shape.empty()) fail("{}: shape is not a list of numbers", part.where);
  return whole_number(shape[0], "shape", part.where);
}

// Version 1 states the number of Gaussians in every part.
void check_shape(const JsonEntry& root, const char* name, std::uint64_t count) {
  if (!root.has(name) || !root.object[name].is_object()) return;
  const JsonEntry part = root.child(name);
  if (!part.has("shape")) return;
  if (const std::uint64_t own = shape_of(part); own != count)
    fail("{}: the shape has {} Gaussians, that of means {}", part.where, own, count);
}

// Version 1 has evenly spaced values instead of a codebook.
ByteTable even_steps(double low, double high) {
  ByteTable table;
  for (std::size_t i = 0; i < table.size(); ++i) {
    const double t = static_cast<double>(i) / 255;
    table[i] = static_cast<float>(low * (1 - t) + high * t);
  }
  return table;
}

void parse_version_2(const JsonEntry& root, SogMeta& meta) {
  meta.count = whole_number(root.get("count"), "count", root.where);
  meta.log_scale.fill(codebook(root.child("scales")));
  meta.dc.fill(codebook(root.child("sh0")));
  for (std::size_t i = 0; i < 256; ++i) meta.logit[i] = logit_of_byte(static_cast<std::uint8_t>(i));
  if (!root.has("shN")) return;
  const JsonEntry sh = root.child("shN");
  const auto bands = whole_number(sh.get("bands"), "bands", sh.where);
  if (bands > 3) fail("{}: {} bands, 1 to 3 exist", sh.where, bands);
  meta.sh_bands = static_cast<int>(bands);
  meta.sh_palette = whole_number(sh.get("count"), "count", sh.where);
  meta.sh = codebook(sh);
}

void parse_version_1(const JsonEntry& root, SogMeta& meta) {
  meta.count = shape_of(root.child("means"));
  for (const char* part : {"scales", "quats", "sh0", "shN"}) check_shape(root, part, meta.count);
  const JsonEntry scale = root.child("scales");
  const auto scale_low = scale.vector<3>("mins"), scale_high = scale.vector<3>("maxs");
  const JsonEntry color = root.child("sh0");
  const auto color_low = color.vector<4>("mins"), color_high = color.vector<4>("maxs");
  for (int i = 0; i < 3; ++i) {
    meta.log_scale[static_cast<std::size_t>(i)] = even_steps(scale_low[i], scale_high[i]);
    meta.dc[static_cast<std::size_t>(i)] = even_steps(color_low[i], color_high[i]);
  }
  meta.logit = even_steps(color_low[3], color_high[3]);
  const JsonEntry rotation = root.child("quats");
  if (rotation.has("encoding") && rotation.text("encoding") != "quaternion_packed")
    fail("{}: encoding '{}' is not known", rotation.where, rotation.text("encoding").substr(0, 40));
  if (!root.has("shN")) return;
  const JsonEntry sh = root.child("shN");
  meta.sh_bands = -1;
  meta.sh = even_steps(sh.number("mins"), sh.number("maxs"));
}

int version_of(const JsonEntry& root) {
  if (!root.has("version")) return 1;
  const double version = root.number("version");
  if (version != 1 && version != 2)
    fail("{}: SOG version {}, but versions 1 and 2 are read", root.where, version);
  return static_cast<int>(version);
}

}  // namespace

SogDecoder::SogDecoder(std::string_view meta, const std::string& source, FileSource& files,
                       const std::string& folder, ThreadPool& pool)
    : meta_(parse_sog_meta(meta, source)) {
  // List the pictures of the file.
  const std::uint64_t max_texels = 2 * meta_.count + kSpareTexels;
  std::vector<Picture> pictures = {{meta_.positions_low, max_texels, &positions_low_},
                                   {meta_.positions_high, max_texels, &positions_high_},
                                   {meta_.scales, max_texels, &scales_},
                                   {meta_.rotations, max_texels, &rotations_},
                                   {meta_.colors, max_texels, &colors_}};
  if (meta_.sh_bands != 0) {
    pictures.push_back({meta_.labels, max_texels, &labels_});
    pictures.push_back({meta_.centroids, kMaxCentroidTexels, &centroids_});
  }
  // Read the pictures and check their sizes before anything is decoded.
  for (Picture& picture : pictures) {
    picture.packed = files.read(folder + picture.name, packed_bytes(picture.max_texels));
    picture_bytes_ += picture.packed.size();
    const std::string where = source + ": " + picture.name;
    const WebpSize size = webp_size(picture.packed, where);
    if (size.pixels() > picture.max_texels)
      fail("{}: {} x {} pixels are more than its {} Gaussians need", where, size.width, size.height,
           meta_.count);
    if (picture.pixels == &centroids_) {
      const std::uint64_t rest = size.width / kCentroidsPerRow;
      if (meta_.sh_bands < 0) meta_.sh_bands = rest == 3 ? 1 : rest == 8 ? 2 : 3;
      const auto expected =
          static_cast<std::uint64_t>(sh_coefficient_count(meta_.sh_bands) - 1) * kCentroidsPerRow;
      if (size.width != expected)
        fail("{}: {} pixels wide, {} bands need {}", where, size.width, meta_.sh_bands, expected);
      centroid_columns_ = size.width;
      palette_ = size.height * kCentroidsPerRow;
      if (meta_.sh_palette > palette_)
        fail("{}: {} x {} pixels are too few for {} rows of coefficients", where, size.width,
             size.height, meta_.sh_palette);
      if (meta_.sh_palette > 0) palette_ = meta_.sh_palette;
    } else if (size.pixels() < meta_.count) {
      fail("{}: {} x {} pixels are too few for {} Gaussians", where, size.width, size.height,
           meta_.count);
    }
  }
  degree_ = meta_.sh_bands;
  if (!fits(meta_.count, 1, picture_bytes_ * kMaxGaussiansPerByte))
    fail("{}: {} Gaussians are announced, more than pictures of {} bytes can hold", source,
         meta_.count, picture_bytes_);
  // Decode.
  pool.for_each(pictures.size(), 1, [&](std::size_t i) {
    *pictures[i].pixels = decode_webp(pictures[i].packed, source + ": " + pictures[i].name);
  });
}

void SogDecoder::fill(std::uint64_t from, GaussianCloud& cloud, std::size_t to) {
  const std::uint64_t texel = 4 * from;
  // Position and scale.
  for (int axis = 0; axis < 3; ++axis) {
    const std::uint64_t at = texel + static_cast<std::uint64_t>(axis);
    const double t = (positions_low_[at] + 256.0 * positions_high_[at]) / 65535;
    const double low = meta_.position_low[axis], high = meta_.position_high[axis];
    cloud.positions[to][axis] = static_cast<float>(from_log(low + (high - low) * t));
    cloud.log_scales[to][axis] = meta_.log_scale[static_cast<std::size_t>(axis)][scales_[at]];
  }

  // Rotation: three components, and in alpha the number of the largest one, which is left out.
  constexpr int kFirstTag = 252;
  const std::uint8_t* const q = &rotations_[texel];
  if (q[3] < kFirstTag) {
    cloud.rotations[to] = make_quat(1, 0, 0, 0);
    ++unrotated_;
  } else {
    const auto component = [q](int i) { return (q[i] / 127.5 - 1) * std::sqrt(0.5); };
    const auto wxyz = restore_largest({component(0), component(1), component(2)},
                                      static_cast<std::size_t>(q[3] - kFirstTag));
    cloud.rotations[to] = make_quat(wxyz[0], wxyz[1], wxyz[2], wxyz[3]);
  }

  // Opacity and base colour.
  glm::vec3* const sh = sh_of(cloud, to);
  std::fill_n(sh, sh_count(cloud), glm::vec3(0));
  const std::uint8_t* const color = &colors_[texel];
  sh[0] = {meta_.dc[0][color[0]], meta_.dc[1][color[1]], meta_.dc[2][color[2]]};
  cloud.opacity_logits[to] = meta_.logit[color[3]];
  if (degree_ == 0) return;
  // View-dependent colour: a row of the palette.
  const std::uint64_t label = labels_[texel] + 256u * labels_[texel + 1];
  if (label >= palette_) {
    ++unlabelled_;
    return;
  }
  // A row of the picture holds 64 centroids; each takes one texel per coefficient.
  const std::uint64_t rest = centroid_columns_ / kCentroidsPerRow;
  const std::uint8_t* const row = &centroids_[4 * (label / kCentroidsPerRow * centroid_columns_ +
                                                   label % kCentroidsPerRow * rest)];
  for (std::size_t k = 0; k < rest; ++k)
    sh[1 + k] = {meta_.sh[row[4 * k]], meta_.sh[row[4 * k + 1]], meta_.sh[row[4 * k + 2]]};
}

SogMeta parse_sog_meta(std::string_view text, const std::string& source) {
  const json object = parse_json(text, source);
  if (!object.is_object()) fail("{}: not a JSON object", source);
  const JsonEntry root{object, source};
  SogMeta meta;
  meta.version = version_of(root);
  meta.version == 1 ? parse_version_1(root, meta) : parse_version_2(root, meta);
  if (root.has("model")) meta.model = root.text("model");
  const JsonEntry means = root.child("means");
  meta.position_low = means.vector<3>("mins");
  meta.position_high = means.vector<3>("maxs");
  meta.positions_low = file_name(means, 0, 2);
  meta.positions_high = file_name(means, 1, 2);
  meta.scales = file_name(root.child("scales"), 0, 1);
  meta.rotations = file_name(root.child("quats"), 0, 1);
  meta.colors = file_name(root.child("sh0"), 0, 1);
  if (meta.sh_bands != 0) {
    const JsonEntry sh = root.child("shN");
    meta.centroids = file_name(sh, 0, 2);
    meta.labels = file_name(sh, 1, 2);
  }
  return meta;
}

}  // namespace qs
