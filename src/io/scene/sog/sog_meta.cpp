// SPDX-License-Identifier: MIT
#include <cmath>

#include "io/bytes/json_entry.h"
#include "io/bytes/json_text.h"
#include "io/cloud/quantised.h"
#include "io/scene/sog/sog_decoder.h"

namespace qs {
namespace {

using json = nlohmann::json;

// Largest count that is exact as a double and far from overflow.
constexpr double kMaxCount = 1e12;

std::uint64_t whole_number(const json& value, const char* key, const std::string& where) {
  if (!value.is_number()) fail("{}: {} is not a number", where, key);
  const auto number = value.get<double>();
  if (!(number >= 1 && number <= kMaxCount && number == std::floor(number))) {
    fail("{}: {} is {}, but must be a whole number from 1 up", where, key, number);
  }
  return static_cast<std::uint64_t>(number);
}

const std::string& file_name(const JsonEntry& part, std::size_t index, std::size_t count) {
  const json& files = part.get("files");
  if (!files.is_array() || files.size() != count || !files[index].is_string()) {
    fail("{}: files is not a list of {} names", part.where, count);
  }
  return files[index].get_ref<const std::string&>();
}

ByteTable codebook(const JsonEntry& part) {
  const json& list = part.get("codebook");
  ByteTable table;
  if (!list.is_array() || list.size() != table.size()) {
    fail("{}: codebook is not a list of {} numbers", part.where, table.size());
  }
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
  if (rotation.has("encoding") && rotation.text("encoding") != "quaternion_packed") {
    fail("{}: encoding '{}' is not known", rotation.where, rotation.text("encoding").substr(0, 40));
  }
  if (!root.has("shN")) return;
  const JsonEntry sh = root.child("shN");
  meta.sh_bands = -1;
  meta.sh = even_steps(sh.number("mins"), sh.number("maxs"));
}

int version_of(const JsonEntry& root) {
  if (!root.has("version")) return 1;
  const double version = root.number("version");
  if (version != 1 && version != 2) fail("{}: SOG version {}, 1 and 2 exist", root.where, version);
  return static_cast<int>(version);
}

}  // namespace

SogMeta parse_sog_meta(std::string_view text, const std::string& source) {
  const json object = parse_json(text, source);
  if (!object.is_object()) fail("{}: not a JSON object", source);
  const JsonEntry root{object, source};
  SogMeta meta;
  meta.version = version_of(root);
  meta.version == 1 ? parse_version_1(root, meta) : parse_version_2(root, meta);
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
