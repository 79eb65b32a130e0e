// SPDX-License-Identifier: MIT
#include "raster/lens/lens_map.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

namespace qs {
namespace {

constexpr double kRadians = std::numbers::pi / 180;
const double kHalfBlend = std::sin(0.5 * kBlendDegrees * kRadians);

// The directions that a face shows.
struct Cell {
  glm::dmat3 axes;                    // columns right, down, forward of its face
  std::array<glm::dvec3, 4> borders;  // unit normals of its sides, inwards
  double least_cosine;                // of the angle to its forward axis, blending included

  // 1 inside, 0 outside, and a half at the border.
  double weight_of(const glm::dvec3& direction) const {
    if (glm::dot(axes[2], direction) < least_cosine) return 0;
    double inside = 1;
    for (const glm::dvec3& border : borders) inside = std::min(inside, glm::dot(border, direction));
    return std::clamp(0.5 + 0.5 * inside / kHalfBlend, 0.0, 1.0);
  }

  // The largest |x/z| and |y/z| of the face: of the corners of its outer borders.
  double edge() const {
    double result = 0;
    for (const glm::dvec3& a : borders)
      for (const glm::dvec3& b : borders) {
        const glm::dvec3 along = glm::cross(a, b);
        if (glm::dot(along, axes[2]) <= 0) continue;
        const glm::dvec3 outwards = -kHalfBlend / (1 + glm::dot(a, b)) * (a + b);
        const glm::dvec3 corner =
            outwards + std::sqrt(1 - glm::dot(outwards, outwards)) * glm::normalize(along);
        const auto within = [&](const glm::dvec3& border) {
          return glm::dot(border, corner) > -kHalfBlend - 1e-9;
        };
        const glm::dvec3 in_face = corner * axes;  // the transposed axes times it
        if (std::ranges::all_of(borders, within))
          result =
              std::max({result, std::abs(in_face.x / in_face.z), std::abs(in_face.y / in_face.z)});
      }
    return result;
  }
};

// The widest angle of a cell to its axis: of a cube's corner, and of the middle of a cube's side.
double least_cosine(double widest_degrees) {
  return std::cos((widest_degrees + kBlendDegrees) * kRadians);
}

Cell side_of_cube(const glm::dmat3& cube) {
  const double half = std::numbers::sqrt2 / 2;
  return {cube,
          {half * (cube[2] + cube[0]), half * (cube[2] - cube[0]), half * (cube[2] + cube[1]),
           half * (cube[2] - cube[1])},
          least_cosine(54.74)};
}

// A quarter of a cube's side: `x` and `y` are -1 or 1. Its right and down axes are symmetric to the
// cube's, so that the cell fits into a small square.
Cell quarter_of(const glm::dmat3& cube, double x, double y) {
  const double slope = std::tan(22.5 * kRadians), half = std::numbers::sqrt2 / 2;
  const glm::dvec3 forward = glm::normalize(cube[2] + slope * x * cube[0] + slope * y * cube[1]);
  const auto across = [&](const glm::dvec3& axis) {
    return glm::normalize(axis - forward * glm::dot(forward, axis));
  };
  const glm::dvec3 right = across(cube[0]), down = across(cube[1]);
  const glm::dvec3 sum = glm::normalize(right + down), difference = glm::normalize(right - down);
  return {
      glm::dmat3(half * (sum + difference), half * (sum - difference), forward),
      {x * cube[0], y * cube[1], half * (cube[2] - x * cube[0]), half * (cube[2] - y * cube[1])},
      least_cosine(30.37)};
}

std::vector<Cell> cells_of(int faces) {
  std::vector<Cell> cells;
  for (const glm::dmat3& cube : kCubeAxes) {
    if (faces == kFewFaces) {
      cells.push_back(side_of_cube(cube));
      continue;
    }
    for (const double y : {-1.0, 1.0})
      for (const double x : {-1.0, 1.0}) cells.push_back(quarter_of(cube, x, y));
  }
  return cells;
}

// The face's pixels count from its axis; cuts the face to them.
void cut(FaceMap& face, double focal) {
  glm::vec2 low(std::numeric_limits<float>::max()), high = -low;
  for (const FacePixel& pixel : face.pixels) {
    low = glm::min(low, glm::vec2(pixel.x, pixel.y));
    high = glm::max(high, glm::vec2(pixel.x, pixel.y));
  }
  // Interpolation reads the pixel before a position and two behind it.
  const glm::vec2 first = glm::floor(low) - 1.0f, last = glm::floor(high) + 2.0f;
  for (FacePixel& pixel : face.pixels) {
    pixel.x -= first.x;
    pixel.y -= first.y;
  }
  face.camera.focal_px = glm::dvec2(focal);
  face.camera.center_px = -glm::dvec2(first);
  face.camera.width = static_cast<int>(last.x - first.x) + 1;
  face.camera.height = static_cast<int>(last.y - first.y) + 1;
  face.camera.projection = Projection::face;
}

}  // namespace

Camera FaceMap::placed(const Camera& lens) const {
  Camera result = camera;
  result.view_from_world = glm::transpose(lens_from_face) * lens.view_from_world;
  result.near_depth = lens.near_depth;
  result.name = lens.name;
  result.origin = lens.origin;
  return result;
}

LensMap make_lens_map(const SizedLens& lens, glm::ivec2 size, int faces, ThreadPool& pool) {
  const std::vector<Cell> cells = cells_of(faces);
  // Pixels of a face for each pixel of the lens, along a line. The 6 faces of a panorama have as
  // many pixels as its picture.
  const double scale = faces == kFewFaces ? std::sqrt(0.75) : 1.5;
  const double focal = scale * lens.pixels_per_radian;
  const auto width = static_cast<std::size_t>(size.x), rows = static_cast<std::size_t>(size.y);
  LensMap map{size,
              {},
              std::pow(focal / lens.middle_pixels_per_radian, 2),
              std::vector<std::uint8_t>(width * rows, LensMap::kNoFace)};

  constexpr std::size_t kRows = 16;  // of a chunk
  std::vector<std::vector<std::vector<FacePixel>>> chunks((rows + kRows - 1) / kRows);
  pool.for_chunks(rows, kRows, [&](std::size_t begin, std::size_t end, int) {
    auto& of_cells = chunks[begin / kRows];
    of_cells.resize(cells.size());
    for (std::size_t at = begin * width; at < end * width; ++at) {
      const auto shown = lens.direction({at % width, at / width});
      if (!shown) continue;
      const glm::dvec3 direction = glm::normalize(*shown);
      double sum = 0, most = 0;
      std::array<double, kManyFaces> weights;
      for (std::size_t c = 0; c < cells.size(); ++c) {
        sum += weights[c] = cells[c].weight_of(direction);
        if (weights[c] <= most) continue;
        most = weights[c];
        map.nearest[at] = static_cast<std::uint8_t>(c);
      }
      for (std::size_t c = 0; c < cells.size(); ++c) {
        if (weights[c] == 0) continue;
        const glm::dvec3 in_face = direction * cells[c].axes;  // the transposed axes times it
        const glm::dvec2 place = focal * glm::dvec2(in_face) / in_face.z;
        of_cells[c].push_back({static_cast<std::uint32_t>(at), static_cast<float>(place.x),
                               static_cast<float>(place.y), static_cast<float>(weights[c] / sum)});
      }
    }
  });

  std::array<std::uint8_t, 256> places{};
  places[LensMap::kNoFace] = LensMap::kNoFace;
  for (std::size_t c = 0; c < cells.size(); ++c) {
    FaceMap face{cells[c].axes, {}, {}};
    for (const auto& of_cells : chunks)
      face.pixels.insert(face.pixels.end(), of_cells[c].begin(), of_cells[c].end());
    if (face.pixels.empty()) continue;
    cut(face, focal);
    face.camera.face_edge = cells[c].edge();
    places[c] = static_cast<std::uint8_t>(map.faces.size());
    map.faces.push_back(std::move(face));
  }
  for (std::uint8_t& face : map.nearest) face = places[face];
  return map;
}

}  // namespace qs
