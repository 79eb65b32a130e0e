// SPDX-License-Identifier: MIT
#include "raster/lens/lens_renderer.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "base/fail.h"
#include "raster/lens/added_face.h"
#include "raster/lens/lens_renderer_of.h"

namespace qs {
namespace lens {

Camera leveled(Camera camera, const glm::dvec3& up) {
  const glm::dmat3 axes = glm::transpose(glm::dmat3(camera.view_from_world));
  const glm::dvec3 eye = camera.position();
  const auto flat = [&](const glm::dvec3& v) { return v - up * glm::dot(up, v); };
  constexpr double kFlat = 1e-3;
  glm::dvec3 forward = flat(axes[2]);
  if (glm::length(forward) < kFlat) forward = flat(-axes[1]) * -glm::sign(glm::dot(axes[2], up));
  forward = glm::normalize(forward);
  const glm::dmat3 turn = glm::transpose(glm::dmat3(glm::cross(forward, up), -up, forward));
  camera.view_from_world = glm::dmat4x3(turn[0], turn[1], turn[2], -(turn * eye));
  return camera;
}

Camera parallel(Camera camera, double height) {
  camera.projection = Projection::orthographic;
  camera.focal_px = glm::dvec2(camera.height / height);
  camera.center_px = 0.5 * glm::dvec2(camera.width - 1, camera.height - 1);
  return camera;
}

Camera eye_of_lens(Camera camera, double side, double eye_distance) {
  camera.view_from_world[3].x -= side * eye_distance;
  return camera;
}

void add(RenderStats& sum, const RenderStats& face) {
  sum.cpu_ms += face.cpu_ms;
  sum.count_ms += face.count_ms;
  for (int stage = 0; stage < kStageCount; ++stage) sum.stage_ms[stage] += face.stage_ms[stage];
  sum.pipeline = face.pipeline;
  sum.gaussians = face.gaussians;
  sum.threads = face.threads;
  sum.visible += face.visible;
  sum.tile_pairs += face.tile_pairs;
  sum.listed += face.listed;
  sum.sort_bytes += face.sort_bytes;
  sum.max_pairs_in_a_tile = std::max(sum.max_pairs_in_a_tile, face.max_pairs_in_a_tile);
  if (face.used_pairs) sum.used_pairs = sum.used_pairs.value_or(0) + *face.used_pairs;
}

void add(std::vector<ModePairs>& sum, const std::vector<ModePairs>& face) {
  sum.resize(std::max(sum.size(), face.size()));
  for (std::size_t mode = 0; mode < face.size(); ++mode) {
    sum[mode].tile_pairs += face[mode].tile_pairs;
    sum[mode].visible += face[mode].visible;
  }
}

void check_outputs(const LensView& lens, const Outputs& outputs, const Target& target) {
  if (outputs.trace || outputs.region || outputs.seen || outputs.share ||
      std::holds_alternative<GlTexture>(target))
    fail(
        ErrorKind::device,
        "lens {}: its faces are separate pictures: there is no trace, no region, no texture and no "
        "selection of the whole",
        lens.text);
}

CountMaps::CountMaps(const TileGrid& grid, glm::ivec2 size, const Outputs& outputs)
    : grid_(grid), width_(size.x) {
  const auto tiles = static_cast<std::size_t>(grid.count());
  if (outputs.pairs) pairs_.resize(tiles);
  if (outputs.used) used_.resize(tiles);
  if (outputs.evaluated)
    evaluated_.resize(static_cast<std::size_t>(size.x) * static_cast<std::size_t>(size.y));
}

void CountMaps::add(const LensMap& map, std::size_t number, const Frame& face,
                    std::size_t first_pixel) {
  if (pairs_.empty() && used_.empty() && evaluated_.empty()) return;
  const FaceMap& own = map.faces[number];
  const auto tile_at = [](const TileGrid& grid, std::size_t x, std::size_t y) {
    const auto side = static_cast<std::size_t>(grid.tile_px);
    return y / side * static_cast<std::size_t>(grid.columns) + x / side;
  };
  const auto column = [](const FacePixel& pixel) {
    return static_cast<std::size_t>(pixel.x + 0.5f);
  };
  const auto row = [](const FacePixel& pixel) { return static_cast<std::size_t>(pixel.y + 0.5f); };
  std::vector<double> shown;  // pixels of the picture, per tile of the face
  if (!pairs_.empty() || !used_.empty()) shown.resize(static_cast<std::size_t>(face.grid.count()));
  if (!shown.empty())
    for (const FacePixel& pixel : own.pixels)
      shown[tile_at(face.grid, column(pixel), row(pixel))] += double{pixel.weight};
  for (const FacePixel& pixel : own.pixels) {
    const std::size_t at = first_pixel + pixel.pixel;
    const auto width = static_cast<std::size_t>(width_);
    if (!shown.empty()) {
      const std::size_t from = tile_at(face.grid, column(pixel), row(pixel));
      const std::size_t to = tile_at(grid_, at % width, at / width);
      const double share = double{pixel.weight} / shown[from];
      if (!pairs_.empty()) pairs_[to] += share * face.pairs[from];
      if (!used_.empty()) used_[to] += share * face.used[from];
    }
    if (!evaluated_.empty() && map.nearest[pixel.pixel] == number)
      evaluated_[at] =
          face.evaluated[row(pixel) * static_cast<std::size_t>(own.camera.width) + column(pixel)];
  }
}

void CountMaps::finish(Frame& result) const {
  for (const double pairs : pairs_)
    result.pairs.push_back(static_cast<std::uint32_t>(std::lround(pairs)));
  for (const double used : used_)
    result.used.push_back(static_cast<std::uint32_t>(std::lround(used)));
  result.evaluated = evaluated_;
}

}  // namespace lens

namespace {

// Sums in the host's memory.
class HostFaceSums {
 public:
  explicit HostFaceSums(ThreadPool& pool) : pool_(pool) {}

  Target face_target() const { return HostImage{}; }

  void begin(glm::ivec2 size, const Outputs& outputs) {
    color_ = outputs.color ? Image(size.x, size.y, 3) : Image();
    depth_ = {};
    if (!outputs.depth) return;
    const auto pixels = static_cast<std::size_t>(size.x) * static_cast<std::size_t>(size.y);
    for (std::vector<float>* map : {&depth_.alpha, &depth_.expected, &depth_.median})
      map->assign(pixels, 0);
  }

  void begin_eye(std::shared_ptr<const LensMap> map, std::size_t first_pixel,
                 const glm::vec3& background) {
    map_ = std::move(map);
    eye_ = SummedMaps{color_.values.empty() ? nullptr : color_.values.data(),
                      depth_.alpha.empty() ? nullptr : depth_.alpha.data(), depth_.expected.data(),
                      depth_.median.data()}
               .from(first_pixel);
    if (eye_.color == nullptr) return;
    pool_.for_each(map_->nearest.size(), 1 << 16, [&](std::size_t at) {
      if (map_->nearest[at] != LensMap::kNoFace) return;
      for (int c = 0; c < 3; ++c) eye_.color[3 * at + static_cast<std::size_t>(c)] = background[c];
    });
  }

  void add(const Frame& frame, std::size_t number) {
    const FaceMap& face = map_->faces[number];
    const AddedFace added{{frame.color.values.data(), frame.depth.alpha.data(),
                           frame.depth.expected.data(), frame.depth.median.data()},
                          face.camera.width,
                          eye_,
                          map_->nearest.data(),
                          static_cast<std::uint8_t>(number)};
    pool_.for_each(face.pixels.size(), 1 << 14, [&](std::size_t k) { added.add(face.pixels[k]); });
  }

  void wait() const {}

  void finish(const Target&, Frame& result) {
    result.color = std::move(color_);
    result.depth = std::move(depth_);
  }

 private:
  ThreadPool& pool_;
  Image color_;
  DepthMaps depth_;
  std::shared_ptr<const LensMap> map_;
  SummedMaps eye_;
};

}  // namespace

std::unique_ptr<Renderer> with_lenses(std::unique_ptr<Renderer> inner, ThreadPool& pool) {
  return std::make_unique<LensRenderer<HostFaceSums>>(std::move(inner), pool, pool);
}

}  // namespace qs
