// SPDX-License-Identifier: MIT
#include "io/edits/measures_file.h"

#include <cmath>

#include <glm/geometric.hpp>

#include "base/json_of.h"
#include "io/edits/scene_entry.h"

namespace qs {
namespace {

using nlohmann::ordered_json;

// Squares of places and lengths are finite.
constexpr double kFarthest = 1e15;

glm::dvec3 near_place(SceneEntry& entry, const char* key) {
  const glm::dvec3 place = entry.place(key);
  if (!(glm::length(place) <= kFarthest))
    fail("{}: {} is farther than {:g} from the scene", entry.where, key, kFarthest);
  return place;
}

glm::dvec3 unit_vector(SceneEntry& entry, const char* key) {
  entry.known.insert(key);
  const auto vector = entry.vector<3>(key);
  if (!(std::abs(glm::length(vector) - 1) < 1e-6))
    fail("{}: {} is not of length 1", entry.where, key);
  return vector;
}

SurfacePoint parse_point(SceneEntry& entry) {
  SurfacePoint point;
  point.position = near_place(entry, "position");
  if (entry.reads("direction")) point.direction = unit_vector(entry, "direction");
  const auto length = [&](const char* key) {
    return entry.reads(key) ? entry.number_within(key, 0, kFarthest) : 0;
  };
  point.distance = length("distance");
  point.along = length("along");
  point.across = length("across");
  return point;
}

ordered_json point_json(const SurfacePoint& point, const glm::dvec3& origin) {
  ordered_json json = {{"position", json_of(point.position + origin)}};
  if (point.direction != glm::dvec3(0)) json["direction"] = json_of(point.direction);
  json["distance"] = point.distance;
  json["along"] = point.along;
  json["across"] = point.across;
  return json;
}

}  // namespace

MeasuresFile read_measures(const std::filesystem::path& path, const glm::dvec3& origin) {
  return parse_measures(read_text_file(path, kMaxMeasureBytes), path.string(), origin);
}

MeasuresFile parse_measures(std::string_view text, const std::string& source,
                            const glm::dvec3& origin) {
  const nlohmann::json json = parse_json(text, source);
  if (!json.is_object()) fail("{}: is not a file of measures: it has no object", source);
  SceneEntry entry{{json, source}, origin};
  if (!entry.reads("version") || !entry.reads("lines"))
    fail("{}: is not a file of measures: it has no version or no lines", source);
  if (const double version = entry.number("version"); version != 1)
    fail("{}: version {} is not readable, only 1", source, version);
  MeasuresFile file;
  file.scene = entry.scene(file.warnings);
  if (entry.reads("scale")) {
    SceneEntry scale{entry.child("scale"), origin};
    file.measures.scale.factor = scale.number_within("factor", 1e-9, 1e9);
    if (scale.reads("error")) file.measures.scale.error = scale.number_within("error", 0, 1e9);
    if (scale.reads("unit"))
      file.measures.scale.unit = kLengthUnits[scale.word<std::size_t>("unit", kLengthUnits)];
    scale.warn_unknown(file.warnings);
  }
  if (entry.reads("ground")) {
    SceneEntry ground{entry.child("ground"), origin};
    file.measures.ground = {near_place(ground, "point"), unit_vector(ground, "up")};
    ground.warn_unknown(file.warnings);
  }
  std::size_t count = 0;
  const auto list_in = [](const nlohmann::json& list, const std::string& where) -> const auto& {
    if (!list.is_array()) fail("{}: is not a list", where);
    return list;
  };
  file.measures.lines.clear();
  for (const auto& line : list_in(entry.get("lines"), source + ": lines")) {
    file.measures.lines.emplace_back();
    const std::string where = fmt::format("{}: line {}", source, file.measures.lines.size());
    for (const auto& each : list_in(line, where)) {
      if (++count > kMaxMeasuredPoints)
        fail("{}: there are more than {} points", source, grouped(kMaxMeasuredPoints));
      const std::string name = fmt::format("{}: point {}", source, count);
      if (!each.is_object()) fail("{}: is not an object", name);
      SceneEntry point{{each, name}, origin};
      file.measures.lines.back().push_back(parse_point(point));
      point.warn_unknown(file.warnings);
    }
  }
  if (file.measures.lines.empty()) file.measures.lines.emplace_back();
  entry.warn_unknown(file.warnings);
  return file;
}

std::string format_measures(const MeasuresFile& file, const glm::dvec3& origin) {
  const Measures& measures = file.measures;
  std::string text =
      fmt::format("{{\"version\": 1,\n \"scene\": {},\n", json_line(json_of(file.scene)));
  if (const MeasureScale& scale = measures.scale; scale != MeasureScale()) {
    ordered_json json = {{"factor", scale.factor}, {"error", scale.error}};
    if (!scale.unit.empty()) json["unit"] = scale.unit;
    text += fmt::format(" \"scale\": {},\n", json_line(json));
  }
  if (const auto& ground = measures.ground)
    text += fmt::format(" \"ground\": {},\n", json_line({{"point", json_of(ground->point + origin)},
                                                         {"up", json_of(ground->up)}}));
  text += " \"lines\": [";
  const char* between = "\n  [";
  for (const auto& line : measures.lines) {
    for (const SurfacePoint& point : line) {
      text += between + json_line(point_json(point, origin));
      between = ",\n   ";
    }
    if (!line.empty()) {
      text += "]";
      between = ",\n  [";
    }
  }
  return text + "\n ]}\n";
}

}  // namespace qs
