// SPDX-License-Identifier: MIT
#include <algorithm>

#include <fmt/format.h>
#include <imgui.h>
#include <imgui_stdlib.h>

#include "app/viewer/panels/panels.h"
#include "app/viewer/panels/style.h"

namespace qs {

void draw_keys(const std::vector<block::Key>& keys) {
  for (std::size_t i = 0; i < keys.size(); ++i) {
    if (i > 0) same_line_if_fits(ImGui::CalcTextSize(keys[i].text.c_str()).x);
    ImGui::TextColored(palette::text_of(keys[i].ink), "%s", keys[i].text.c_str());
  }
}

namespace {

constexpr int kListLines = 10;

// The new file's name and its button.
void draw_crop_file(const Viewer& viewer, PanelState& state, Actions& actions) {
  if (!viewer.editing.gone) return;
  ImGui::SetNextItemWidth(-1);
  ImGui::InputTextWithHint("##file", "new file, e.g. cropped.ply; empty: a free name",
                           &state.crop_file);
  if (ImGui::Button("Save as"))
    actions.push_back(call(action::save_crop, std::filesystem::path(state.crop_file), Action()));
  command_tooltip("Save the cropped scene");
}

void draw_bookmarks(const Viewer& viewer, Actions& actions) {
  for (std::size_t i = 0; i < bookmarks_of(viewer).size(); ++i) {
    ImGui::PushID(static_cast<int>(i));
    if (ImGui::Button("x")) actions.push_back(call(action::remove_bookmark, i));
    ImGui::SameLine();
    if (ImGui::Button("Go")) actions.push_back(call(action::go_to_bookmark, i));
    ImGui::SameLine();
    ImGui::SetNextItemWidth(-1);
    std::string name = bookmarks_of(viewer)[i].first;
    if (ImGui::InputText("##name", &name)) actions.push_back(call(action::name_bookmark, i, name));
    ImGui::PopID();
  }
}

void draw_shape(const block::Shape& shape, const std::vector<ImVec2>& points) {
  ImDrawList& draw = *ImGui::GetWindowDrawList();
  const ImU32 color = color_of(shape.ink, shape.opacity);
  if (shape.is_box && shape.width == 0) return draw.AddRectFilled(points[0], points[1], color);
  if (shape.is_box) return draw.AddRect(points[0], points[1], color, 0, 0, shape.width);
  const ImDrawFlags closed = points.size() > 2 ? ImDrawFlags_Closed : 0;
  draw.AddPolyline(points.data(), static_cast<int>(points.size()), color, closed, shape.width);
}

// The kinds of blocks, one function each.
struct BlockDrawer {
  const Viewer& viewer;
  PanelState& state;
  Actions& actions;
  ControlsDrawer controls{viewer, actions};

  void operator()(const block::Text& block) const {
    if (block.text.empty()) return;
    constexpr const ImVec4* kColors[] = {&palette::kText, &palette::kFaint, &palette::kCaution};
    if (block.follows) ImGui::SameLine();
    draw_wrapped(*kColors[static_cast<int>(block.tone)], block.text);
  }
  void operator()(const block::Line&) const { ImGui::Separator(); }
  void operator()(const block::Facts& block) const {
    const float letter = ImGui::GetFontSize();
    const bool is_narrow = ImGui::GetContentRegionAvail().x < 12 * letter;
    for (const Fact& fact : block.facts) {
      ImGui::TextColored(palette::kFaint, "%s", fact.label.c_str());
      if (!is_narrow) ImGui::SameLine(8 * letter);
      ImGui::TextWrapped("%s", fact.value.c_str());
    }
  }
  void operator()(const block::Progress& block) const {
    ImGui::ProgressBar(static_cast<float>(block.share), {-1, 0});
  }
  void operator()(const block::Controls& block) const {
    if (block.indented) ImGui::Indent();
    for (const block::Placed& placed : block.controls) controls.draw(placed);
    if (block.indented) ImGui::Unindent();
  }
  void operator()(const block::Keys& block) const { draw_keys(block.keys); }
  void operator()(const block::ColorBar& block) const { draw_color_bar(block.legend); }
  void operator()(const block::Table& block) const { draw_table(block, state, controls); }
  void operator()(const block::Chart& block) const { draw_chart(block); }

  void operator()(const block::List& block) const {
    ImGui::BeginChild("list", {0, kListLines * ImGui::GetTextLineHeightWithSpacing()});
    ImGuiListClipper clipper;
    clipper.Begin(static_cast<int>(block.count));
    while (clipper.Step()) {
      for (int i = clipper.DisplayStart; i < clipper.DisplayEnd; ++i) {
        const auto index = static_cast<std::size_t>(i);
        if (ImGui::Selectable(block.label(index).c_str(), block.chosen == index))
          controls.set(block.control, 0, index);
      }
    }
    ImGui::EndChild();
  }

  void operator()(const block::Items& block) const {
    for (std::size_t row = 0; row < block.rows.size(); ++row) {
      ImGui::PushID(static_cast<int>(row));
      ImGui::AlignTextToFramePadding();
      for (std::size_t i = 0; i < block.rows[row].size(); ++i) {
        if (i > 0) ImGui::SameLine();
        draw_item(block.rows[row][i], row);
      }
      ImGui::PopID();
    }
  }
  void draw_item(const block::Item& item, std::size_t row) const {
    const char* const label = item.label.c_str();
    if (item.kind == ControlKind::button && ImGui::SmallButton(label))
      controls.set(item.control, 0, row);
    const ImVec2 size{8 * ImGui::GetFontSize(), 0};
    if (item.kind == ControlKind::item && ImGui::Selectable(label, false, 0, size))
      controls.set(item.control, 0, row);
    bool is_on = item.value != 0;
    if (item.kind == ControlKind::toggle && ImGui::Checkbox(label, &is_on))
      controls.set(item.control, is_on ? 1 : 0, row);
    if (item.kind == ControlKind::number) {
      ImGui::SetNextItemWidth(5 * ImGui::GetFontSize());
      double value = item.value;
      if (ImGui::DragScalar("##number", ImGuiDataType_Double, &value, 0.02f, &item.least,
                            &item.most, "+%.2f s"))
        controls.set(item.control, value, row);
    }
    controls.show_tooltip(item.control);
  }

  void operator()(const block::Figure& block) const {
    constexpr float kMostScale = 40;
    const glm::vec2 extent = block.high - block.low;
    const float width = ImGui::GetContentRegionAvail().x, letter = ImGui::GetFontSize();
    const float scale = std::min({width / extent.x, 18 * letter / extent.y, kMostScale});
    const ImVec2 at = ImGui::GetCursorScreenPos();
    const ImVec2 end{at.x + width, at.y + extent.y * scale};
    ImDrawList& draw = *ImGui::GetWindowDrawList();
    draw.PushClipRect(at, end, true);
    draw.AddRectFilled(at, end, ImGui::GetColorU32(ImGuiCol_Text, 0.04f));
    const glm::vec2 origin(at.x + 0.5f * (width - extent.x * scale), at.y);
    for (const block::Shape& shape : block.shapes) {
      std::vector<ImVec2> points;
      for (const glm::vec2 point : shape.points) {
        const glm::vec2 place = origin + (point - block.low) * scale;
        points.push_back({place.x, place.y});
      }
      draw_shape(shape, points);
    }
    draw.PopClipRect();
    ImGui::Dummy({width, end.y - at.y});
  }

  void operator()(const block::Plot& block) const {
    const float most = *std::ranges::max_element(block.values);
    ImGui::PlotLines("##plot", block.values.data(), static_cast<int>(block.values.size()), 0,
                     nullptr, 0, most * 1.15f,
                     {ImGui::GetContentRegionAvail().x, 3.2f * ImGui::GetFontSize()});
    ImGui::TextColored(palette::kFaint, "%s", block.caption.c_str());
  }

  void operator()(block::Local part) const {
    if (part == block::Local::test_view) draw_test_view(viewer, state, actions);
    if (part == block::Local::crop_file) draw_crop_file(viewer, state, actions);
    if (part == block::Local::bookmarks) draw_bookmarks(viewer, actions);
    if (part == block::Local::messages) draw_log(viewer, actions);
  }
};

}  // namespace

void draw_blocks(const Blocks& blocks, const Viewer& viewer, PanelState& state, Actions& actions) {
  const BlockDrawer drawer{viewer, state, actions};
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    ImGui::PushID(static_cast<int>(i));
    std::visit(drawer, blocks[i]);
    ImGui::PopID();
  }
}

}  // namespace qs
