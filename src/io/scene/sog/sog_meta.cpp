// SPDX-License-Identifier: MIT
#include "io/scene/sog/sog_meta.h"

#include <cmath>

#include "io/bytes/json_entry.h"
#include "io/bytes/json_text.h"
#include "io/cloud/quantised.h"

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

const json& object_in(const json& parent, const char* key, const std::string& where) {
  const json& value = JsonEntry{parent, where}.get(key);
  if (!value.is_object()) fail("{}: {} is not an object", where, key);
  return value;
}

const std::string& file_name(const json& part, std::size_t index, std::size_t count,
                             const std::string& where) {
  const json& files = JsonEntry{part, where}.get("files");
  if (!files.is_array() || files.size() != count || !files[index].is_string()) {
    fail("{}: files is not a list of {} names", where, count);
  }
  return files[index].get_ref<const std::string&>();
}

ByteTable codebook(const json& part, const std::string& where) {
  const json& list = JsonEntry{part, where}.get("codebook");
  ByteTable table;
  if (!list.is_array() || list.size() != table.size()) {
    fail("{}: codebook is not a list of {} numbers", where, table.size());
  }
  for (std::size_t i = 0; i < table.size(); ++i) {
    table[i] = static_cast<float>(JsonEntry{part, where}.number(list[i], "codebook"));
  }
  return table;
}

// Version 1 states the number of Gaussians in every part.
void check_shape(const json& part, const char* name, std::uint64_t count,
                 const std::string& source) {
  const std::string where = fmt::format("{}: {}", source, name);
  if (!part.is_object() || !JsonEntry{part, where}.has("shape")) return;
  const json& shape = part["shape"];
  if (!shape.is_array() || shape.empty()) fail("{}: shape is not a list of numbers", where);
  if (const std::uint64_t own = whole_number(shape[0], "shape", where); own != count)
    fail("{}: the shape has {} Gaussians, that of means {}", where, own, count);
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

void parse_version_2(const json& root, const std::string& source, SogMeta& meta) {
  meta.count = whole_number(JsonEntry{root, source}.get("count"), "count", source);
  meta.log_scale.fill(codebook(object_in(root, "scales", source), source + ": scales"));
  meta.dc.fill(codebook(object_in(root, "sh0", source), source + ": sh0"));
  for (std::size_t i = 0; i < 256; ++i) meta.logit[i] = logit_of_byte(static_cast<std::uint8_t>(i));
  const JsonEntry entry{root, source};
  if (!entry.has("shN")) return;
  const json& sh = object_in(root, "shN", source);
  const std::string where = source + ": shN";
  const auto bands = whole_number(JsonEntry{sh, where}.get("bands"), "bands", where);
  if (bands > 3) fail("{}: {} bands, 1 to 3 exist", where, bands);
  meta.sh_bands = static_cast<int>(bands);
  meta.sh_palette = whole_number(JsonEntry{sh, where}.get("count"), "count", where);
  meta.sh = codebook(sh, where);
}

void parse_version_1(const json& root, const std::string& source, SogMeta& meta) {
  const std::string means = source + ": means", scales = source + ": scales",
                    colors = source + ": sh0", rotations = source + ": quats";
  const json& shape = JsonEntry{object_in(root, "means", source), means}.get("shape");
  if (!shape.is_array() || shape.empty()) fail("{}: shape is not a list of numbers", means);
  meta.count = whole_number(shape[0], "shape", means);

  for (const char* part : {"scales", "quats", "sh0", "shN"}) {
    if (JsonEntry{root, source}.has(part)) check_shape(root[part], part, meta.count, source);
  }

  const JsonEntry scale{object_in(root, "scales", source), scales};
  const auto scale_low = scale.vector<3>(scale.get("mins"), "mins");
  const auto scale_high = scale.vector<3>(scale.get("maxs"), "maxs");
  const JsonEntry color{object_in(root, "sh0", source), colors};
  const auto color_low = color.vector<4>(color.get("mins"), "mins");
  const auto color_high = color.vector<4>(color.get("maxs"), "maxs");
  for (int i = 0; i < 3; ++i) {
    meta.log_scale[static_cast<std::size_t>(i)] = even_steps(scale_low[i], scale_high[i]);
    meta.dc[static_cast<std::size_t>(i)] = even_steps(color_low[i], color_high[i]);
  }
  meta.logit = even_steps(color_low[3], color_high[3]);

  const JsonEntry rotation{object_in(root, "quats", source), rotations};
  if (rotation.has("encoding") && rotation.text("encoding") != "quaternion_packed") {
    fail("{}: encoding '{}' is not known", rotations, rotation.text("encoding").substr(0, 40));
  }
  const JsonEntry entry{root, source};
  if (!entry.has("shN")) return;
  const std::string where = source + ": shN";
  const JsonEntry sh{object_in(root, "shN", source), where};
  meta.sh_bands = -1;
  meta.sh = even_steps(sh.number(sh.get("mins"), "mins"), sh.number(sh.get("maxs"), "maxs"));
}

int version_of(const json& root, const std::string& source) {
  const JsonEntry entry{root, source};
  if (!entry.has("version")) return 1;
  const double version = entry.number(root["version"], "version");
  if (version != 1 && version != 2) fail("{}: SOG version {}, 1 and 2 exist", source, version);
  return static_cast<int>(version);
}

}  // namespace

SogMeta parse_sog_meta(std::string_view text, const std::string& source) {
  const json root = parse_json(text, source);
  if (!root.is_object()) fail("{}: not a JSON object", source);
  SogMeta meta;
  meta.version = version_of(root, source);
  meta.version == 1 ? parse_version_1(root, source, meta) : parse_version_2(root, source, meta);

  const std::string where = source + ": means";
  const json& means = object_in(root, "means", source);
  const JsonEntry entry{means, where};
  meta.position_low = entry.vector<3>(entry.get("mins"), "mins");
  meta.position_high = entry.vector<3>(entry.get("maxs"), "maxs");
  meta.positions_low = file_name(means, 0, 2, where);
  meta.positions_high = file_name(means, 1, 2, where);
  meta.scales = file_name(object_in(root, "scales", source), 0, 1, source + ": scales");
  meta.rotations = file_name(object_in(root, "quats", source), 0, 1, source + ": quats");
  meta.colors = file_name(object_in(root, "sh0", source), 0, 1, source + ": sh0");
  if (meta.sh_bands != 0) {
    const json& sh = object_in(root, "shN", source);
    meta.centroids = file_name(sh, 0, 2, source + ": shN");
    meta.labels = file_name(sh, 1, 2, source + ": shN");
  }
  return meta;
}

}  // namespace qs
