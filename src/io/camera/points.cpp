// SPDX-License-Identifier: MIT
//
// The files of points beside cameras. A .ply has x, y, z and colours as red, green, blue (or r, g,
// b), integers or 0..1, or as the f_dc of Gaussians; points without colours are gray.
#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "base/fail.h"
#include "base/path_kind.h"
#include "base/text.h"
#include "io/bytes/byte_text.h"
#include "io/bytes/mapped_file.h"
#include "io/camera/cameras.h"
#include "io/scene/ply/ply_file.h"

namespace qs {
namespace {

constexpr float kShOfGray = 0.28209479f;  // the constant spherical harmonic

// A colour is gray + column / white.
struct ColorColumns {
  std::array<const PlyColumn*, 3> columns{};
  double white = 1, gray = 0;

  bool exist() const { return columns[0] != nullptr && columns[1] != nullptr && columns[2]; }
};

ColorColumns color_columns(const PlyRows& rows) {
  for (const auto& names : {std::array{"red", "green", "blue"}, std::array{"r", "g", "b"},
                            std::array{"diffuse_red", "diffuse_green", "diffuse_blue"},
                            std::array{"f_dc_0", "f_dc_1", "f_dc_2"}}) {
    ColorColumns colors{{rows.find(names[0]), rows.find(names[1]), rows.find(names[2])}};
    if (!colors.exist()) continue;
    const PlyType type = colors.columns[0]->type;
    if (std::string_view(names[0]) == "f_dc_0") {
      colors.white = 1 / kShOfGray;
      colors.gray = 0.5;
    } else if (type != PlyType::f32 && type != PlyType::f64) {
      colors.white = size_of(type) == 1 ? 255 : 65535;
    } else {
      // Some programs write 0..255 as floats, and text has no types.
      for (const PlyColumn* column : colors.columns)
        for (std::uint64_t row = 0; row < rows.count && colors.white < 65535; ++row)
          if (const double value = rows.value(row, *column); value > colors.white)
            colors.white = value > 255 ? 65535 : 255;
    }
    return colors;
  }
  return {};
}

}  // namespace

std::optional<std::filesystem::path> find_points_file(const std::filesystem::path& model,
                                                      const std::filesystem::path& data) {
  constexpr int kMostLevels = 3;  // sparse/0, sparse and the data set
  std::filesystem::path folder = model;
  for (int level = 0; level < kMostLevels; ++level, folder = folder.parent_path()) {
    // INRIA's trainer writes points3d.ply into data sets without points, nerfstudio sparse_pc.ply.
    for (const char* name :
         {"points3D.bin", "points3D.txt", "points3D.ply", "points3d.ply", "sparse_pc.ply"})
      if (is_file(folder / name)) return (folder / name).lexically_normal();
    std::error_code error;
    if (std::filesystem::equivalent(folder, data, error)) break;
  }
  return std::nullopt;
}

std::vector<ScenePoint> read_points(const std::filesystem::path& file,
                                    std::vector<std::string>& warnings) {
  const std::string ending = lower_case(file.extension().string());
  const auto read = ending == ".ply"   ? read_ply_points
                    : ending == ".txt" ? read_colmap_points_text
                    : ending == ".bin" ? read_colmap_points_binary
                                       : nullptr;
  if (read == nullptr) fail("{}: points are read from .ply, .bin and .txt", file.string());
  std::vector<ScenePoint> points = read(file);
  const std::size_t all = points.size();
  const std::size_t odd = std::erase_if(points, [](const ScenePoint& point) {
    const glm::vec3 sum = glm::vec3(point.position) + point.color;
    return !std::isfinite(sum.x) || !std::isfinite(sum.y) || !std::isfinite(sum.z);
  });
  if (odd > 0)
    warnings.push_back(fmt::format("{}: {} of {} left out, because numbers are not finite",
                                   file.string(), odd, counted(all, "point")));
  return points;
}

std::vector<ScenePoint> read_ply_points(const std::filesystem::path& file) {
  const MappedFile content(file);
  if (!is_ply(content.content())) fail("{}: not a .ply file of points", file.string());
  const PlyHeader header = parse_ply_header(content.content(), file);
  const Progress progress;
  PlyBody body(content.content(), header, file, progress);
  const PlyRows rows = body.rows("vertex");
  const std::string path = file.string();
  const std::array place = {rows.of_vertices("x", path), rows.of_vertices("y", path),
                            rows.of_vertices("z", path)};
  const ColorColumns colors = color_columns(rows);
  std::vector<ScenePoint> points(rows.count);
  for (std::uint64_t row = 0; row < rows.count; ++row) {
    ScenePoint& point = points[row];
    point.position = {rows.value(row, place[0]), rows.value(row, place[1]),
                      rows.value(row, place[2])};
    point.color = glm::vec3(0.5f);
    for (std::size_t c = 0; colors.exist() && c < 3; ++c)
      point.color[static_cast<int>(c)] = std::clamp(
          static_cast<float>(colors.gray + rows.value(row, *colors.columns[c]) / colors.white),
          0.0f, 1.0f);
  }
  return points;
}

std::vector<ScenePoint> without_repetitions(const std::vector<ScenePoint>& points) {
  struct Kept {
    std::size_t place;
    glm::dvec3 colors;
    int count;
  };
  std::map<std::array<float, 3>, Kept> kept;
  std::vector<ScenePoint> once;
  for (const ScenePoint& point : points) {
    const glm::vec3 p(point.position);
    const auto [found, added] =
        kept.try_emplace({p.x, p.y, p.z}, Kept{once.size(), glm::dvec3(0), 0});
    if (added) once.push_back(point);
    found->second.colors += glm::dvec3(point.color);
    ++found->second.count;
  }
  for (const auto& [position, point] : kept)
    if (point.count > 1)
      once[point.place].color = glm::vec3(point.colors / static_cast<double>(point.count));
  return once;
}

}  // namespace qs
