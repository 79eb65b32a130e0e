// SPDX-License-Identifier: MIT
#include "app/picture/canvas.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <vector>

#include <glm/geometric.hpp>
#include <imgui.h>

#include "base/assets.h"
#include "raster/kernel/tile_grid.h"

namespace qs {
namespace {

// Removes the first code point from `text` and returns it, or '?' if it has three or four bytes.
ImWchar take_character(std::string_view& text) {
  const auto byte = [&text](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  std::size_t length = byte(0) < 0x80 ? 1 : byte(0) < 0xe0 ? 2 : byte(0) < 0xf0 ? 3 : 4;
  length = std::min(length, text.size());
  ImWchar character = '?';
  if (byte(0) < 0x80) character = byte(0);
  if (length == 2) character = static_cast<ImWchar>((byte(0) & 0x1f) << 6 | (byte(1) & 0x3f));
  text.remove_prefix(length);
  return character;
}

/// Calls visit(glyph, pen) for the glyphs of a line from left to right. Returns the line's width.
template <class Visit>
float for_each_glyph(const ImFont& font, std::string_view text, const Visit& visit) {
  float pen = 0;
  while (!text.empty()) {
    const ImFontGlyph& glyph = *font.FindGlyph(take_character(text));
    visit(glyph, pen);
    pen += glyph.AdvanceX;
  }
  return pen;
}

/// Calls set(x, y, channel) for every place of `rect` that is inside of the picture.
template <class Set>
void for_each_value(const Image& image, PixelRect rect, const Set& set) {
  assert(image.channels == 3);
  const int x_end = std::min(rect.x + rect.width, image.width);
  const int y_end = std::min(rect.y + rect.height, image.height);
  for (int y = std::max(rect.y, 0); y < y_end; ++y)
    for (int x = std::max(rect.x, 0); x < x_end; ++x)
      for (int c = 0; c < 3; ++c) set(x, y, c);
}

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
    for (int y = rows.begin; y < rows.end; ++y)
      for (int x = columns.begin; x < columns.end; ++x)
        if (at(x, y) > 0) mix(image, x, y, color, opacity * at(x, y));
  }
};

/// 1 inside a dash, 0 in a gap, at the distance `along` from the line's start.
float dash_coverage(float along, float dash) {
  const float phase = std::fmod(along, 2 * dash);
  return std::clamp(0.5f * dash - std::abs(phase - 0.5f * dash) + 0.5f, 0.0f, 1.0f);
}

}  // namespace

Font::Font(int line_height)
    : line_height_(std::max(line_height, 8)), atlas_(std::make_unique<ImFontAtlas>()) {
  ImFontConfig config;
  config.OversampleH = 1;  // glyphs are placed on whole pixels and copied texel by texel
  config.PixelSnapH = true;
  const auto size = static_cast<float>(line_height_);
  if (const auto file = find_font())
    font_ = atlas_->AddFontFromFileTTF(file->c_str(), size, &config);
  if (!font_) {
    config.SizePixels = size;
    font_ = atlas_->AddFontDefault(&config);
  }
  unsigned char* texels = nullptr;
  atlas_->GetTexDataAsAlpha8(&texels, &texture_width_, &texture_height_);
  texels_ = texels;
}

Font::~Font() = default;

int Font::width(std::string_view text) const {
  return static_cast<int>(std::ceil(for_each_glyph(*font_, text, [](const auto&, float) {})));
}

void Font::draw(Image& image, glm::ivec2 at, std::string_view text, glm::vec3 color) const {
  assert(image.channels == 3);
  const auto texel = [](float share, int size) {
    return static_cast<int>(std::lround(share * static_cast<float>(size)));
  };
  for_each_glyph(*font_, text, [&](const ImFontGlyph& glyph, float pen) {
    const int u = texel(glyph.U0, texture_width_), u_end = texel(glyph.U1, texture_width_);
    const int v = texel(glyph.V0, texture_height_), v_end = texel(glyph.V1, texture_height_);
    const int right = at.x + static_cast<int>(std::lround(pen + glyph.X0)) - u;
    const int down = at.y + static_cast<int>(std::lround(glyph.Y0)) - v;
    for_each_value(image, {right + u, down + v, u_end - u, v_end - v}, [&](int x, int y, int c) {
      const unsigned char coverage = texels_[(y - down) * texture_width_ + x - right];
      float& value = image.at(x, y, c);
      value += static_cast<float>(coverage) / 255 * (color[c] - value);
    });
  });
}

Image plain_picture(int width, int height, glm::vec3 color) {
  return picture_of(width, height, [&](int, int, int c) { return color[c]; });
}

void fill_rect(Image& image, PixelRect rect, glm::vec3 color) {
  for_each_value(image, rect, [&](int x, int y, int c) { image.at(x, y, c) = color[c]; });
}

void paste(Image& image, const Image& part, glm::ivec2 at) {
  assert(part.channels == 3);
  for_each_value(image, {at.x, at.y, part.width, part.height},
                 [&](int x, int y, int c) { image.at(x, y, c) = part.at(x - at.x, y - at.y, c); });
}

Image cropped(const Image& image, PixelRect part) {
  return picture_of(part.width, part.height, [&](int x, int y, int c) {
    return std::clamp(image.at(part.x + x, part.y + y, c), 0.0f, 1.0f);
  });
}

int draw_text(Image& image, const Font& font, glm::ivec2 at, std::string_view text, glm::vec3 color,
              Align align) {
  const int width = font.width(text);
  if (align == Align::center) at.x -= width / 2;
  if (align == Align::right) at.x -= width;
  font.draw(image, at, text, color);
  return width;
}

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
      std::ranges::sort(crossings);
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

glm::ivec2 enlarged_size(PixelRect part, double zoom) {
  return {static_cast<int>(std::lround(part.width * zoom)),
          static_cast<int>(std::lround(part.height * zoom))};
}

Image enlarged(const Image& image, PixelRect part, double zoom) {
  const Image source = cropped(image, part);
  const glm::ivec2 size = enlarged_size(part, zoom);
  // The two pixels around a pixel's centre, and the weight of the second.
  struct Between {
    int first, second;
    float weight;
  };
  const auto between = [zoom](int pixel, int count) {
    const double center =
        std::clamp((pixel + 0.5) / zoom - 0.5, 0.0, static_cast<double>(count - 1));
    const int first = static_cast<int>(center);
    return Between{first, std::min(first + 1, count - 1), static_cast<float>(center - first)};
  };
  return picture_of(size.x, size.y, [&](int x, int y, int c) {
    const Between row = between(y, source.height), column = between(x, source.width);
    const auto of_row = [&](int from) {
      return source.at(column.first, from, c) * (1 - column.weight) +
             source.at(column.second, from, c) * column.weight;
    };
    return of_row(row.first) * (1 - row.weight) + of_row(row.second) * row.weight;
  });
}

Image with_inset(const Image& image, PixelRect part, double zoom) {
  constexpr glm::vec3 kFrame{0.9f, 0.1f, 0.1f};
  const int frame = std::max(1, std::min(image.width, image.height) / 250);
  const Image inset = enlarged(image, part, zoom);
  Image result = cropped(image, {0, 0, image.width, image.height});
  const auto paste_framed = [&](const Image& content, glm::ivec2 at) {
    fill_rect(result,
              {at.x - frame, at.y - frame, content.width + 2 * frame, content.height + 2 * frame},
              kFrame);
    paste(result, content, at);
  };
  const bool left = 2 * part.x + part.width > image.width;
  const bool top = 2 * part.y + part.height > image.height;
  paste_framed(cropped(image, part), {part.x, part.y});
  paste_framed(inset,
               {left ? 0 : image.width - inset.width, top ? 0 : image.height - inset.height});
  return result;
}

}  // namespace qs
