// SPDX-License-Identifier: MIT
#include "app/inspect/frame_canvas.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <glm/common.hpp>

#include "app/picture/canvas.h"
#include "app/picture/palette.h"

namespace qs {
namespace {

std::array<glm::vec2, 4> corners(glm::vec2 low, glm::vec2 high) {
  return {low, glm::vec2(high.x, low.y), high, glm::vec2(low.x, high.y)};
}

}  // namespace

Box box_of_tile(const TileGrid& grid, int tile) {
  const glm::vec2 low =
      static_cast<float>(grid.tile_px) * glm::vec2(tile % grid.columns, tile / grid.columns);
  return {low, low + static_cast<float>(grid.tile_px)};
}

FrameCanvas::FrameCanvas(const Box& window, glm::ivec2 size, float scale_limit) : window_(window) {
  const glm::vec2 extent = window.high - window.low, room(size);
  scale_ = std::min({room.x / extent.x, room.y / extent.y, scale_limit});
  picture_ = Image(static_cast<int>(std::ceil(extent.x * scale_)),
                   static_cast<int>(std::ceil(extent.y * scale_)), 3);
  fill_rect(picture_, {0, 0, picture_.width, picture_.height}, on_white::kPanel);
}

void FrameCanvas::draw_frame(const Image& color, float strength) {
  for (int y = 0; y < picture_.height; ++y) {
    for (int x = 0; x < picture_.width; ++x) {
      const glm::vec2 at = glm::floor(window_.low + (glm::vec2(x, y) + 0.5f) / scale_ + 0.5f);
      const glm::ivec2 pixel(at);
      if (pixel.x < 0 || pixel.y < 0 || pixel.x >= color.width || pixel.y >= color.height) continue;
      for (int c = 0; c < 3; ++c) {
        const float value = std::clamp(color.at(pixel.x, pixel.y, c), 0.0f, 1.0f);
        picture_.at(x, y, c) = 1 - strength + strength * value;
      }
    }
  }
}

void FrameCanvas::draw_grid(const TileGrid& grid, glm::vec2 image_size) {
  const auto side = static_cast<float>(grid.tile_px);
  const Pen pen{kGray, 1, 0.55f};
  for (float x = std::ceil(window_.low.x / side) * side; x <= window_.high.x; x += side)
    draw_line({x, window_.low.y}, {x, window_.high.y}, pen);
  for (float y = std::ceil(window_.low.y / side) * side; y <= window_.high.y; y += side)
    draw_line({window_.low.x, y}, {window_.high.x, y}, pen);
  outline_box({{0, 0}, image_size}, {on_white::kInk, 2, 0.6f});
}

void FrameCanvas::fill_box(const Box& box, glm::vec3 color, float opacity) {
  fill_polygon(picture_, corners(to_picture(box.low), to_picture(box.high)), color, opacity);
}

void FrameCanvas::outline_box(const Box& box, const Pen& pen) {
  stroke(picture_, corners(to_picture(box.low), to_picture(box.high)), true, pen);
}

void FrameCanvas::draw_ellipse(const Footprint& footprint, const Pen& pen, float fill_opacity) {
  std::vector<glm::vec2> points = ellipse_of(footprint, 360);
  for (glm::vec2& point : points) point = to_picture(point);
  if (fill_opacity > 0) fill_polygon(picture_, points, pen.color, fill_opacity);
  stroke(picture_, points, true, pen);
}

void FrameCanvas::draw_dot(glm::vec2 at, float radius, glm::vec3 color) {
  const glm::vec2 center = to_picture(at);
  const glm::vec2 points[] = {center, center + glm::vec2(0.01f, 0)};
  stroke(picture_, points, false, {color, 2 * radius});
}

void FrameCanvas::draw_line(glm::vec2 from, glm::vec2 to, const Pen& pen) {
  const glm::vec2 points[] = {to_picture(from), to_picture(to)};
  stroke(picture_, points, false, pen);
}

Box window_of(const GaussianReport& report, const TileGrid& grid) {
  glm::vec2 low = report.footprint.mean_px, high = low;
  if (report.visible) {
    low = glm::min(low, report.adr.low);
    high = glm::max(high, report.adr.high);
  }
  const auto side = static_cast<float>(grid.tile_px);
  for (const ModeTiles& mode : report.modes) {
    for (const int tile : mode.tiles) {
      const Box box = box_of_tile(grid, tile);
      low = glm::min(low, box.low);
      high = glm::max(high, box.high);
    }
  }
  // At most two tiles beyond the image are shown.
  const glm::vec2 last = side * glm::vec2(grid.columns, grid.rows);
  low = glm::clamp(low, glm::vec2(-2 * side), last);
  high = glm::clamp(high, glm::vec2(0), last + 2 * side);
  return {glm::floor(low / side) * side - side, glm::ceil(high / side) * side + side};
}

}  // namespace qs
