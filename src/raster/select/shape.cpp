// SPDX-License-Identifier: MIT
#include "raster/select/shape.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vector_relational.hpp>

namespace qs {
namespace {

// The x at which the line crosses the row y; left of all points if it does not.
double crossing(glm::dvec2 from, glm::dvec2 to, double y) {
  if ((from.y > y) == (to.y > y)) return -std::numeric_limits<double>::infinity();
  return (to.x - from.x) * (y - from.y) / (to.y - from.y) + from.x;
}

double distance2(glm::dvec2 from, glm::dvec2 to, glm::dvec2 point) {
  const glm::dvec2 along = to - from, offset = point - from;
  const double length2 = glm::dot(along, along);
  const double at = length2 > 0 ? std::clamp(glm::dot(offset, along) / length2, 0.0, 1.0) : 0;
  const glm::dvec2 rest = offset - at * along;
  return glm::dot(rest, rest);
}

}  // namespace

Shape::Shape(std::vector<Line> lines, double radius) : radius_(radius) {
  if (lines.empty()) return;
  low_ = high_ = lines.front().from;
  for (const Line& line : lines) {
    low_ = glm::min(low_, glm::min(line.from, line.to));
    high_ = glm::max(high_, glm::max(line.from, line.to));
  }
  low_ -= radius;
  high_ += radius;
  constexpr std::size_t kMostRows = 256;
  const std::size_t rows = std::min(kMostRows, lines.size());
  row_height_ = std::max((high_.y - low_.y) / static_cast<double>(rows), 1e-9);
  std::vector<std::vector<Line>> of_row(rows);
  const auto row_of = [&](double y) {
    const double row = std::floor((y - low_.y) / row_height_);
    return static_cast<std::size_t>(std::clamp(row, 0.0, static_cast<double>(rows - 1)));
  };
  for (const Line& line : lines) {
    const auto [upper, lower] = std::minmax(line.from.y, line.to.y);
    for (std::size_t row = row_of(upper - radius); row <= row_of(lower + radius); ++row)
      of_row[row].push_back(line);
  }
  for (const std::vector<Line>& row : of_row) {
    row_begin_.push_back(lines_.size());
    lines_.insert(lines_.end(), row.begin(), row.end());
  }
  row_begin_.push_back(lines_.size());
}

Shape Shape::polygon(std::span<const glm::dvec2> corners) {
  std::vector<Line> lines;
  for (std::size_t i = 0; corners.size() > 2 && i < corners.size(); ++i)
    lines.push_back({corners[i], corners[(i + 1) % corners.size()]});
  return Shape(std::move(lines), 0);
}

Shape Shape::rectangle(glm::dvec2 a, glm::dvec2 b) {
  return polygon(std::array{a, glm::dvec2(b.x, a.y), b, glm::dvec2(a.x, b.y)});
}

Shape Shape::stroke(std::span<const glm::dvec2> points, double radius) {
  std::vector<Line> lines;
  for (std::size_t i = 0; i < points.size(); ++i)
    lines.push_back({points[i > 0 ? i - 1 : 0], points[i]});
  return Shape(std::move(lines), radius);
}

std::span<const Shape::Line> Shape::near(double y) const {
  const std::size_t rows = row_begin_.size() - 1;
  const double row =
      std::clamp(std::floor((y - low_.y) / row_height_), 0.0, static_cast<double>(rows - 1));
  const auto at = static_cast<std::size_t>(row);
  return std::span(lines_).subspan(row_begin_[at], row_begin_[at + 1] - row_begin_[at]);
}

bool Shape::has_border_near(glm::dvec2 point, double distance) const {
  if (lines_.empty() || glm::any(glm::lessThan(point, low_ - distance)) ||
      glm::any(glm::greaterThan(point, high_ + distance)))
    return false;
  double nearest2 = std::numeric_limits<double>::infinity();
  for (const Line& line : lines_)
    nearest2 = std::min(nearest2, distance2(line.from, line.to, point));
  return std::abs(std::sqrt(nearest2) - radius_) <= distance;
}

bool Shape::contains(glm::dvec2 point) const {
  if (lines_.empty() || !(point.x >= low_.x && point.x <= high_.x) ||
      !(point.y >= low_.y && point.y <= high_.y))
    return false;
  if (radius_ > 0)
    return std::ranges::any_of(near(point.y), [&](const Line& line) {
      return distance2(line.from, line.to, point) <= radius_ * radius_;
    });
  bool inside = false;
  for (const Line& line : near(point.y)) inside ^= point.x < crossing(line.from, line.to, point.y);
  return inside;
}

void Shape::choose_row(glm::ivec2 first, std::span<std::uint8_t> row) const {
  if (radius_ > 0) {
    for (std::size_t i = 0; i < row.size(); ++i)
      row[i] = contains(glm::dvec2(first) + glm::dvec2(i, 0));
    return;
  }
  std::ranges::fill(row, std::uint8_t{0});
  for (const Line& line : near(first.y)) {
    const double left = std::ceil(crossing(line.from, line.to, first.y)) - first.x;  // pixels
    const auto count =
        static_cast<std::size_t>(std::clamp(left, 0.0, static_cast<double>(row.size())));
    if (count > 0) row[count - 1] ^= 1;
  }
  for (std::size_t i = row.size(); i-- > 1;) row[i - 1] ^= row[i];
}

PixelBox Shape::pixels(glm::ivec2 size) const {
  if (lines_.empty()) return {};
  const auto clamped = [](double value, int limit) {
    return static_cast<int>(std::clamp(value, 0.0, static_cast<double>(limit)));
  };
  return {clamped(std::ceil(low_.x), size.x), clamped(std::ceil(low_.y), size.y),
          clamped(std::floor(high_.x) + 1, size.x), clamped(std::floor(high_.y) + 1, size.y)};
}

}  // namespace qs
