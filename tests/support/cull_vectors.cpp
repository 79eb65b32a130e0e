// SPDX-License-Identifier: MIT
#include "support/cull_vectors.h"

#include <algorithm>
#include <fstream>
#include <stdexcept>

#include <nlohmann/json.hpp>

#include "support/shared.h"

namespace qs::test {
namespace {

using Json = nlohmann::json;

/// "#" must be listed, "?" may be, "." must not; rows are separated by "/".
TileMap parse_map(const std::string& text, TileGrid grid) {
  const auto columns = static_cast<std::size_t>(grid.columns),
             rows = static_cast<std::size_t>(grid.rows);
  if (text.size() != rows * (columns + 1) - 1) throw std::runtime_error("size of map " + text);
  TileMap map;
  for (int tile = 0; tile < grid.count(); ++tile) {
    const char letter = text[static_cast<std::size_t>(tile + tile / grid.columns)];
    if (letter == '#') map.must.insert(tile);
    if (letter == '?') map.may.insert(tile);
  }
  return map;
}

CullVector parse_vector(const Json& json) {
  CullVector vector;
  vector.name = json["name"];
  vector.width = json["image"][0];
  vector.height = json["image"][1];
  vector.grid = TileGrid::of_image(vector.width, vector.height);
  vector.opacity = json["opacity"];
  const Json &mean = json["mean"], &covariance = json["covariance"];
  vector.footprint =
      qs::make_footprint({mean[0].get<float>(), mean[1].get<float>()},
                         {covariance[0], covariance[1], covariance[2]}, json["gamma"]);
  for (const auto& [name, text] : json["maps"].items())
    vector.maps[name] = parse_map(text, vector.grid);
  return vector;
}

}  // namespace

std::string TileMap::fault_of(const std::set<int>& listed) const {
  for (const int tile : must)
    if (listed.count(tile) == 0) return "tile " + std::to_string(tile) + " is missing";
  for (const int tile : listed)
    if (must.count(tile) + may.count(tile) == 0)
      return "tile " + std::to_string(tile) + " is wrong";
  return "";
}

const CullVector& CullVectors::named(const std::string& name) const {
  const auto found = std::find_if(all.begin(), all.end(),
                                  [&](const CullVector& vector) { return vector.name == name; });
  if (found == all.end()) throw std::runtime_error("no vector " + name);
  return *found;
}

CullVectors read_cull_vectors() {
  const Json json = Json::parse(std::ifstream(source_path("tests/vectors/cull.json")));
  CullVectors vectors;
  vectors.map_of_mode = json["modes"];
  for (const Json& vector : json["vectors"]) vectors.all.push_back(parse_vector(vector));
  return vectors;
}

}  // namespace qs::test
