// SPDX-License-Identifier: MIT
#include "app/picture/stroke.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <glm/geometric.hpp>

#include "raster/kernel/tile_grid.h"

namespace qs {
namespace {

void mix(Image& image, int x, int y, glm::vec3 color, float amount) {
  for (int c = 0; c < 3; ++c) {
    float& value = image.at(x, y, c);
    value += amount * (color[c] - value);
  }
}

/// The coverage, 0..1, of the pixels of a part of the picture.
struct Coverage {
  Span columns, rows;
  std::vector<float> values;

  Coverage(const Image& image, std::span<const glm::vec2> points, float margin)
      : columns(range(points, 0, margin, image.width)),
        rows(range(points, 1, margin, image.height)) {
    values.resize(static_cast<std::size_t>(columns.size()) * static_cast<std::size_t>(rows.size()));
  }

  static Span range(std::span<const glm::vec2> points, int axis, float margin, int limit) {
    float low = INFINITY, high = -INFINITY;
    for (const glm::vec2& p : points) {
      low = std::min(low, p[axis]);
      high = std::max(high, p[axis]);
    }
    return {clamp_to_int(std::floor(low - margin), limit),
            clamp_to_int(std::ceil(high + margin), limit)};
  }

  float& at(int x, int y) {
    return values[static_cast<std::size_t>(y - rows.begin) *
                      static_cast<std::size_t>(columns.size()) +
                  static_cast<std::size_t>(x - columns.begin)];
  }

  void paint(Image& image, glm::vec3 color, float opacity) {
    for (int y = rows.begin; y < rows.end; ++y) {
      for (int x = columns.begin; x < columns.end; ++x) {
        if (at(x, y) > 0) mix(image, x, y, color, opacity * at(x, y));
      }
    }
  }
};

/// 1 inside a dash, 0 in a gap, at the distance `along` from the line's start.
float dash_coverage(float along, float dash) {
  const float phase = std::fmod(along, 2 * dash);
  return std::clamp(0.5f * dash - std::abs(phase - 0.5f * dash) + 0.5f, 0.0f, 1.0f);
}

}  // namespace

void stroke(Image& image, std::span<const glm::vec2> points, bool closed, const Pen& pen) {
  if (points.size() < 2) return;
  const float reach = 0.5f * pen.width + 0.5f;
  Coverage coverage(image, points, reach);
  float start = 0;
  for (std::size_t i = 0; i + (closed ? 0 : 1) < points.size(); ++i) {
    const glm::vec2 a = points[i], b = points[(i + 1) % points.size()];
    const glm::vec2 along = b - a;
    const float length = glm::length(along);
    const glm::vec2 ends[] = {a, b};
    const Span columns =
        intersection(Coverage::range(ends, 0, reach, image.width), coverage.columns);
    const Span rows = intersection(Coverage::range(ends, 1, reach, image.height), coverage.rows);
    for (int y = rows.begin; y < rows.end; ++y) {
      for (int x = columns.begin; x < columns.end; ++x) {
        const glm::vec2 p(static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f);
        const float t =
            length > 0 ? std::clamp(glm::dot(p - a, along) / (length * length), 0.0f, 1.0f) : 0;
        float covered = std::clamp(reach - glm::length(p - a - t * along), 0.0f, 1.0f);
        covered = std::min(covered, pen.width);
        if (pen.dash > 0) covered *= dash_coverage(start + t * length, pen.dash);
        coverage.at(x, y) = std::max(coverage.at(x, y), covered);
      }
    }
    start += length;
  }
  coverage.paint(image, pen.color, pen.opacity);
}

void fill_polygon(Image& image, std::span<const glm::vec2> points, glm::vec3 color, float opacity) {
  if (points.size() < 3) return;
  constexpr int kLines = 4;  // samples per pixel down a column; along a row the coverage is exact
  Coverage coverage(image, points, 0);
  std::vector<float> crossings;
  for (int y = coverage.rows.begin; y < coverage.rows.end; ++y) {
    for (int line = 0; line < kLines; ++line) {
      const float at = static_cast<float>(y) + (static_cast<float>(line) + 0.5f) / kLines;
      crossings.clear();
      for (std::size_t i = 0; i < points.size(); ++i) {
        const glm::vec2 a = points[i], b = points[(i + 1) % points.size()];
        if ((a.y <= at) != (b.y <= at))
          crossings.push_back(a.x + (at - a.y) / (b.y - a.y) * (b.x - a.x));
      }
      std::sort(crossings.begin(), crossings.end());
      for (std::size_t i = 0; i + 1 < crossings.size(); i += 2) {
        const glm::vec2 ends[] = {{crossings[i], at}, {crossings[i + 1], at}};
        const Span run = intersection(Coverage::range(ends, 0, 0, image.width), coverage.columns);
        for (int x = run.begin; x < run.end; ++x) {
          const auto left = static_cast<float>(x);
          const float part = std::min(crossings[i + 1], left + 1) - std::max(crossings[i], left);
          coverage.at(x, y) += std::max(part, 0.0f) / kLines;
        }
      }
    }
  }
  coverage.paint(image, color, opacity);
}

}  // namespace qs
