// SPDX-License-Identifier: MIT
#include "io/camera/lens_views.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <glm/geometric.hpp>

#include "base/fail.h"
#include "base/text.h"
#include "io/camera/colmap.h"

namespace qs {
namespace {

double angle_between(const glm::dvec3& a, const glm::dvec3& b) {
  return std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b));
}

// The angle of a pixel, away from the axis; infinite where the lens shows nothing.
double angle_of_pixel(const Lens& lens, glm::dvec2 pixel) {
  const glm::dvec2 outwards = pixel - lens.center_px;
  const double length = glm::length(outwards);
  const glm::dvec2 step = length > 1 ? outwards / length : glm::dvec2(1, 0);
  const auto a = lens.direction(pixel - 0.5 * step), b = lens.direction(pixel + 0.5 * step);
  return a && b ? angle_between(*a, *b) : std::numeric_limits<double>::infinity();
}

// In front of a picture of lens.size_px.
SizedLens sized(const Lens& lens) {
  const double focal = std::max(lens.focal_px.x, lens.focal_px.y);
  SizedLens result{[lens](glm::dvec2 pixel) { return lens.direction(pixel); }, focal, focal};
  if (lens.model->plane == LensPlane::panorama) return result;
  const double middle = angle_of_pixel(lens, lens.center_px);
  double least = middle;       // at points all over the picture
  constexpr int kPoints = 24;  // per side
  for (int i = 0; i <= kPoints * (kPoints + 2); ++i) {
    const glm::dvec2 share(i % (kPoints + 1), i / (kPoints + 1));
    least = std::min(least, angle_of_pixel(lens, share / double{kPoints} * lens.size_px - 0.5));
  }
  constexpr double kMost = 4;  // next to a pole of a formula no pixel is worth it
  result.pixels_per_radian = std::min(1 / least, kMost * focal);
  if (std::isfinite(middle)) result.middle_pixels_per_radian = 1 / middle;
  return result;
}

}  // namespace

LensView panorama_view(double degrees) {
  const auto at = [degrees](glm::ivec2 size) {
    Lens lens{find_lens_model("EQUIRECTANGULAR"), size};
    lens.focal_px = glm::dvec2(180 / degrees, 1) * lens.size_px / std::numbers::pi;
    lens.center_px = 0.5 * lens.size_px - 0.5;
    return sized(lens);
  };
  return {fmt::format("equirectangular of {} degrees", degrees), at};
}

LensView fisheye_view(double degrees) {
  const auto at = [degrees](glm::ivec2 size) {
    Lens lens{find_lens_model("FISHEYE"), size};
    lens.limit = 0.5 * degrees * std::numbers::pi / 180;
    lens.focal_px = glm::dvec2(0.5 * std::min(size.x, size.y) / lens.limit);
    lens.center_px = 0.5 * lens.size_px - 0.5;
    return sized(lens);
  };
  return {fmt::format("fisheye of {} degrees", degrees), at};
}

LensView parallel_view(double height) {
  return {fmt::format("orthographic, {:g} units high", height), {}, height};
}

LensView photograph_view(const Lens& lens) {
  const auto at = [lens](glm::ivec2 size) {
    return sized(lens.scaled(glm::dvec2(size) / lens.size_px));
  };
  std::vector<double> numbers = {lens.size_px.x, lens.size_px.y};
  if (lens.model->focal_lengths > 0)
    for (const double parameter : colmap_parameters(lens)) numbers.push_back(parameter);
  return {fmt::format("{},{}", lens.model->name, fmt::join(numbers, ",")), at};
}

Lens parse_lens(const std::string& text, const std::string& where) {
  const std::vector<std::string> words = separated(text);
  const LensModel* const model = find_lens_model(words.front());
  if (model == nullptr)
    fail(ErrorKind::usage, "{}: there is no camera model '{}'", where, words.front());
  const auto count = static_cast<std::size_t>(model->focal_lengths == 0 ? 0 : model->parameters());
  std::vector<double> numbers;
  for (std::size_t i = 1; i < words.size(); ++i)
    numbers.push_back(parse_real(where, words[i], -1e9, 1e9));
  if (numbers.size() != 2 + count)
    fail(ErrorKind::usage, "{}: {} needs WIDTH,HEIGHT and {} parameters, but {} numbers follow it",
         where, model->name, count, numbers.size());
  const auto side = [&](double value) {
    return static_cast<std::uint64_t>(std::clamp(value, 0.0, 1e6));
  };
  ColmapLens stored{*model, side(numbers[0]), side(numbers[1]), {}};
  stored.parameters.assign(numbers.begin() + (count == 0 ? 0 : 2), numbers.end());
  return checked_lens(colmap_lens(stored, where), where);
}

}  // namespace qs
