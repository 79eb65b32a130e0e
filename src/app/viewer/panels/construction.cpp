// SPDX-License-Identifier: MIT
#include "app/viewer/panels/construction.h"

#include <algorithm>
#include <span>

#include <fmt/format.h>
#include <imgui.h>

#include "app/inspect/frame_canvas.h"
#include "app/viewer/panels/panels.h"
#include "app/viewer/panels/style.h"

namespace qs {
namespace {

constexpr ImU32 kFigure = IM_COL32(255, 255, 255, 10), kGridLine = IM_COL32(255, 255, 255, 36);

// Draws in pixels of the frame into a rectangle of the window.
struct Figure {
  ImDrawList& draw;
  glm::vec2 origin;  // of the window, screen units
  glm::vec2 low;     // the frame's pixel there
  float scale;       // screen units per pixel

  ImVec2 at(glm::vec2 pixel) const {
    const glm::vec2 place = origin + (pixel - low) * scale;
    return {place.x, place.y};
  }
  void outline(const Box& box, ImU32 color, float width) const {
    draw.AddRect(at(box.low), at(box.high), color, 0, 0, width);
  }
  void fill(const Box& box, ImU32 color) const {
    draw.AddRectFilled(at(box.low), at(box.high), color);
  }
};

void draw_grid(const Figure& figure, const Box& window, const TileGrid& grid) {
  const auto side = static_cast<float>(grid.tile_px);
  const glm::vec2 low = glm::max(window.low, glm::vec2(0));
  const glm::vec2 high = glm::min(window.high, side * glm::vec2(grid.columns, grid.rows));
  for (float x = low.x; x <= high.x; x += side)
    figure.draw.AddLine(figure.at({x, low.y}), figure.at({x, high.y}), kGridLine);
  for (float y = low.y; y <= high.y; y += side)
    figure.draw.AddLine(figure.at({low.x, y}), figure.at({high.x, y}), kGridLine);
}

void draw_boxes(const Figure& figure, const GaussianReport& gaussian) {
  figure.outline(gaussian.square, color_of(on_dark::mode_color(k3dgs)), 1.5f);
  if (!gaussian.visible) return;
  figure.outline(gaussian.adr, color_of(on_dark::mode_color(kAdr)), 1.5f);
  for (const Box& box : gaussian.quad_boxes) {
    figure.fill(box, color_of(on_dark::mode_color(kQuad), 0.12f));
    figure.outline(box, color_of(on_dark::mode_color(kQuad)), 1.5f);
  }
  for (const Box& box : gaussian.dual_boxes)
    figure.outline(box, color_of(on_dark::mode_color(kDual)), 1.5f);
  std::vector<ImVec2> ellipse;
  for (const glm::vec2 point : ellipse_of(gaussian.footprint, 96))
    ellipse.push_back(figure.at(point));
  figure.draw.AddPolyline(ellipse.data(), static_cast<int>(ellipse.size()), color_of(kVermillion),
                          ImDrawFlags_Closed, 2);
}

void draw_construction_legend() {
  std::vector<std::pair<glm::vec3, const char*>> entries = {{kVermillion, "alpha = 1/255"}};
  for (const CullMode mode : {k3dgs, kAdr, kDual, kQuad})
    entries.emplace_back(on_dark::mode_color(mode), mode_name(mode));
  bool first = true;
  for (const auto& [color, text] : entries) {
    if (!first) same_line_if_fits(ImGui::CalcTextSize(text).x);
    first = false;
    ImGui::TextColored(palette::with_opacity(color), "%s", text);
  }
}

void draw_counts(const Inspection& inspection, CullMode shown) {
  if (!ImGui::BeginTable("tiles", 5, ImGuiTableFlags_RowBg | ImGuiTableFlags_SizingStretchProp))
    return;
  ImGui::TableNextRow();
  ImGui::TableNextColumn();
  ImGui::TextColored(palette::kFaint, "%s", kTileColumns[0]);
  ImGui::PushStyleColor(ImGuiCol_Text, palette::kFaint);
  for (const char* title : std::span(kTileColumns).subspan(1)) {
    ImGui::TableNextColumn();
    right_aligned(title);
  }
  ImGui::PopStyleColor();
  for (std::size_t i = 0; i < inspection.gaussian->modes.size(); ++i) {
    const CullMode mode = inspection.gaussian->modes[i].mode;
    const PairUses uses = uses_of(inspection, i);
    ImGui::TableNextRow();
    if (mode == shown)
      ImGui::TableSetBgColor(ImGuiTableBgTarget_RowBg0, ImGui::GetColorU32(ImGuiCol_Header));
    ImGui::TableNextColumn();
    ImGui::TextUnformatted(mode_name(mode));
    for (const std::uint64_t count : {uses.pairs(), uses.used, uses.hidden, uses.empty}) {
      ImGui::TableNextColumn();
      right_aligned(fmt::format("{}", count));
    }
  }
  ImGui::EndTable();
}

}  // namespace

void draw_transmittance(const PixelReport& pixel) {
  const std::vector<Contribution>& list = pixel.contributions;
  if (list.empty()) return;
  const float letter = ImGui::GetFontSize();
  const ImVec2 at = ImGui::GetCursorScreenPos();
  const ImVec2 size{ImGui::GetContentRegionAvail().x, 7 * letter};
  ImDrawList& draw = *ImGui::GetWindowDrawList();
  const ImVec2 low{at.x + 1.6f * letter, at.y + 0.5f * letter};
  const ImVec2 high{at.x + size.x - 0.5f * letter, at.y + size.y - 1.6f * letter};
  const auto place = [&](std::size_t index, float transmittance) {
    const float share = static_cast<float>(index) / static_cast<float>(list.size());
    return ImVec2(low.x + share * (high.x - low.x), high.y - transmittance * (high.y - low.y));
  };
  const ImU32 faint = ImGui::GetColorU32(palette::kFaint);
  draw.AddRectFilled(low, high, kFigure);
  for (const float value : {0.0f, 1.0f}) {
    const float y = place(0, value).y;
    draw.AddLine({low.x, y}, {high.x, y}, kGridLine);
    draw.AddText({at.x + 0.6f * letter, y - 0.5f * letter}, faint, value > 0 ? "1" : "0");
  }
  std::vector<ImVec2> steps;
  for (std::size_t i = 0; i < list.size(); ++i) {
    const float after = i + 1 < list.size() ? list[i + 1].transmittance : pixel.transmittance;
    const ImVec2 begin = place(i, list[i].transmittance), end = place(i + 1, after);
    const glm::vec3 color = glm::clamp(list[i].color, 0.0f, 1.0f);
    draw.AddRectFilled({begin.x, begin.y}, {std::max(end.x, begin.x + 1), high.y},
                       color_of(color, 0.7f));
    steps.insert(steps.end(), {begin, {end.x, begin.y}, end});
  }
  draw.AddPolyline(steps.data(), static_cast<int>(steps.size()), ImGui::GetColorU32(palette::kText),
                   0, 1.5f);
  draw.AddText({low.x, high.y + 0.3f * letter}, faint, kTransmittanceTitle);
  ImGui::Dummy(size);
}

void draw_construction_view(const InspectedView& view, CullMode mode) {
  const GaussianReport& gaussian = *view.inspection.gaussian;
  const Box window = window_of(gaussian, view.grid);
  const glm::vec2 extent = window.high - window.low;
  const float width = ImGui::GetContentRegionAvail().x, letter = ImGui::GetFontSize();
  const float scale = std::min({width / extent.x, 18 * letter / extent.y, 40.0f});
  const ImVec2 at = ImGui::GetCursorScreenPos();
  const ImVec2 size{width, extent.y * scale};
  const float left = at.x + 0.5f * (width - extent.x * scale);
  const Figure figure{*ImGui::GetWindowDrawList(), {left, at.y}, window.low, scale};
  figure.draw.PushClipRect(at, {at.x + size.x, at.y + size.y}, true);
  figure.draw.AddRectFilled(at, {at.x + size.x, at.y + size.y}, kFigure);
  const auto index = static_cast<std::size_t>(inspected_mode(mode) - 1);
  const ModeTiles& listed = gaussian.modes[index];
  for (std::size_t i = 0; i < listed.tiles.size(); ++i) {
    constexpr float kOpacity[] = {0.55f, 0.3f, 0.14f};  // index = PairUse
    const auto use = static_cast<std::size_t>(view.inspection.uses[index][i]);
    figure.fill(box_of_tile(view.grid, listed.tiles[i]),
                color_of(on_dark::mode_color(listed.mode), kOpacity[use]));
  }
  draw_grid(figure, window, view.grid);
  draw_boxes(figure, gaussian);
  const glm::vec2 pixel(view.inspection.pixel.pixel);
  const float half = std::max(0.5f, 4 / scale);
  figure.outline({pixel - half, pixel + half}, IM_COL32(0, 200, 140, 255), 2);
  figure.draw.PopClipRect();
  ImGui::Dummy(size);
  draw_construction_legend();
  ImGui::PushStyleColor(ImGuiCol_Text, palette::kFaint);
  ImGui::TextWrapped("%s", construction_text(listed.mode).c_str());
  ImGui::PopStyleColor();
  draw_counts(view.inspection, listed.mode);
}

}  // namespace qs
