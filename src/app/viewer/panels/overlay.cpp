// SPDX-License-Identifier: MIT
//
// Drawings in the picture: the camera's photograph, the data set's cameras, the pivot, the
// inspected Gaussian, the box of the crop, the verdict of the reference.
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include <imgui.h>

#include "app/framing/camera_control.h"
#include "app/viewer/panels/panels.h"
#include "app/viewer/panels/style.h"
#include "app/viewer/state/measure_actions.h"
#include "app/viewer/state/select_actions.h"

namespace qs {
namespace {

// The picture in the window.
struct Screen {
  const Camera& camera;
  Rect area;
  ImDrawList& draw;
  float scale;  ///< drawing_scale()

  ImVec2 at(glm::dvec2 pixel) const {
    const glm::dvec2 share = (pixel + 0.5) / glm::dvec2(camera.width, camera.height);
    const glm::vec2 place = area.low + glm::vec2(share) * area.size();
    return {place.x, place.y};
  }

  // The pixel at a place in the window.
  glm::dvec2 pixel_at(glm::vec2 place) const {
    const glm::dvec2 share = glm::dvec2(place - area.low) / glm::dvec2(area.size());
    return share * glm::dvec2(camera.width, camera.height) - 0.5;
  }

  // The place of a point in view space, in front of the camera.
  ImVec2 projected(glm::dvec3 point) const {
    return at(glm::dvec2(point) / point.z * camera.focal_px + camera.center_px);
  }
};

// A line between two points of the world.
void draw_line(const Screen& screen, glm::dvec3 from, glm::dvec3 to, ImU32 color, float width) {
  if (const auto line = line_in_picture(screen.camera, from, to))
    screen.draw.AddLine(screen.at(line->from), screen.at(line->to), color, width * screen.scale);
}

void draw_frustum(const Screen& screen, const Camera& camera, double depth, ImU32 color,
                  float width) {
  const glm::dvec3 eye = camera.position();
  const std::array<glm::dvec2, 4> corners = {
      glm::dvec2(-0.5, -0.5), glm::dvec2(camera.width - 0.5, -0.5),
      glm::dvec2(camera.width - 0.5, camera.height - 0.5), glm::dvec2(-0.5, camera.height - 0.5)};
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const glm::dvec3 here = point_at(camera, corners[i], depth);
    const glm::dvec3 next = point_at(camera, corners[(i + 1) % corners.size()], depth);
    draw_line(screen, eye, here, color, width);
    draw_line(screen, here, next, color, width);
  }
}

void draw_photograph(const Viewer& viewer, const PanelState& state, const Screen& screen,
                     Floats& floats, Actions& actions) {
  const auto found = viewer.scene->photographs.find(viewer.dataset_camera);
  if (state.photograph == 0 || found == viewer.scene->photographs.end() ||
      found->second != viewer.photograph.path)
    return;
  // The view has the camera's vertical field of view, so the photograph fills the height.
  const Image& image = *viewer.photograph.image;
  const Rect& area = screen.area;
  const float width = area.size().y * static_cast<float>(image.width) /
                      static_cast<float>(std::max(image.height, 1));
  const float left = 0.5f * (area.low.x + area.high.x - width);
  const float wipe = viewer.photograph_wipe, x = left + wipe * width;
  screen.draw.AddImage(texture_id(state.photograph), {left, area.low.y}, {x, area.high.y}, {0, 0},
                       {wipe, 1}, ImGui::GetColorU32({1, 1, 1, viewer.photograph_opacity}));
  floats.add_plate(FloatKind::photograph, photograph_text(viewer),
                   glm::vec2(std::max(left, area.low.x) + 10, area.low.y));
  const float shown = std::clamp(x, area.low.x + 14, area.high.x - 14);
  if (const auto mouse = draw_divider_line("photograph's edge", area, shown))
    actions.push_back(call(action::set_photograph_wipe, (*mouse - left) / width));
}

// The box of the crop, with handles in the middle of its faces.
void draw_crop_box(const Viewer& viewer, const Screen& screen, Actions& actions) {
  const CropWish& wish = viewer.crop.wish;
  for (const PictureLine& line : box_lines(viewer.camera, wish.box))
    for (const auto& [color, width] :
         {std::pair(ImU32{IM_COL32(0, 0, 0, 160)}, 3.0f), std::pair(color_of(kSkyBlue), 1.5f)})
      screen.draw.AddLine(screen.at(line.from), screen.at(line.to), color, width * screen.scale);
  for (int face = 0; face < kBoxFaces; ++face) {
    const auto pixel = handle_in_picture(viewer.camera, wish.box, face);
    if (!pixel) continue;
    const ImVec2 place = screen.at(*pixel);
    const float radius = 6 * screen.scale;
    if (!(place.x > screen.area.low.x && place.x < screen.area.high.x &&
          place.y > screen.area.low.y && place.y < screen.area.high.y))
      continue;
    screen.draw.AddCircleFilled(place, radius, color_of(kSkyBlue), 24);
    screen.draw.AddCircle(place, radius, IM_COL32(0, 0, 0, 200), 24, 1.5f * screen.scale);
    const glm::vec2 middle(place.x, place.y);
    const std::string name = "crop handle " + std::to_string(face);
    const auto mouse = draw_handle(name.c_str(), {middle - 1.5f * radius, middle + 1.5f * radius},
                                   ImGuiMouseCursor_Hand);
    if (!mouse) continue;
    if (const auto box = dragged(wish.box, face, viewer.camera, screen.pixel_at(*mouse))) {
      CropWish moved = wish;
      moved.box = *box;
      actions.push_back(call(action::change_crop, moved));
    }
  }
}

void draw_label(const Screen& screen, ImVec2 middle, const std::string& text) {
  const ImVec2 size = ImGui::CalcTextSize(text.c_str());
  const ImVec2 low{middle.x - 0.5f * size.x, middle.y - 0.5f * size.y};
  const float margin = 3 * screen.scale;
  screen.draw.AddRectFilled({low.x - margin, low.y - margin},
                            {low.x + size.x + margin, low.y + size.y + margin},
                            IM_COL32(0, 0, 0, 170), margin);
  screen.draw.AddText(low, IM_COL32_WHITE, text.c_str());
}

// The measured lines: parts behind a surface are dashed and faint, soft points are gray.
void draw_rulers(const Viewer& viewer, const Screen& screen) {
  constexpr ImU32 kShadow = IM_COL32(0, 0, 0, 160), kSoft = IM_COL32(170, 170, 170, 255);
  for (const Ruler& ruler : rulers_of(viewer)) {
    const glm::dvec3 from = ruler.from.position, to = ruler.to.position;
    const auto place = [&](std::size_t part) {
      return glm::mix(from, to, static_cast<double>(part) / kRulerParts);
    };
    for (std::size_t part = 0; part < kRulerParts; ++part) {
      const bool hidden = !ruler.hidden.empty() && ruler.hidden[part];
      if (hidden && part % 2 == 1) continue;
      draw_line(screen, place(part), place(part + 1), kShadow, hidden ? 2.5f : 4.0f);
      draw_line(screen, place(part), place(part + 1), color_of(kSkyBlue, hidden ? 0.6f : 1),
                hidden ? 1.0f : 2.0f);
    }
    if (const auto line = line_in_picture(screen.camera, from, to))
      draw_label(screen, screen.at(0.5 * (line->from + line->to)), ruler.text);
  }
  int number = 0;
  for (const auto& line : viewer.measures.lines)
    for (const SurfacePoint& point : line) {
      ++number;
      const glm::dvec3 at = screen.camera.view_from_world * glm::dvec4(point.position, 1);
      if (at.z <= screen.camera.near_depth) continue;
      const ImVec2 place = screen.projected(at);
      screen.draw.AddCircleFilled(place, 5 * screen.scale, kShadow, 24);
      screen.draw.AddCircleFilled(place, 3.5f * screen.scale,
                                  point.is_soft() ? kSoft : color_of(kSkyBlue), 24);
      draw_label(screen, {place.x, place.y - ImGui::GetFontSize()}, std::to_string(number));
    }
}

// The cross that the arrow keys move.
void draw_cross(const Screen& screen, glm::dvec2 pixel) {
  const ImVec2 at = screen.at(pixel);
  const float gap = 3 * screen.scale, end = 12 * screen.scale;
  for (const auto& [color, width] :
       {std::pair(ImU32{IM_COL32(0, 0, 0, 200)}, 3.5f), std::pair(ImU32{IM_COL32_WHITE}, 1.5f)})
    for (const float side : {-1.0f, 1.0f}) {
      screen.draw.AddLine({at.x + side * gap, at.y}, {at.x + side * end, at.y}, color,
                          width * screen.scale);
      screen.draw.AddLine({at.x, at.y + side * gap}, {at.x, at.y + side * end}, color,
                          width * screen.scale);
    }
}

void draw_pivot(const Viewer& viewer, const Screen& screen) {
  const glm::dvec3 at = viewer.camera.view_from_world * glm::dvec4(viewer.pivot, 1);
  if (at.z <= viewer.camera.near_depth) return;
  const ImVec2 place = screen.projected(at);
  screen.draw.AddCircle(place, 7 * screen.scale, IM_COL32(0, 0, 0, 160), 24, 3.5f * screen.scale);
  screen.draw.AddCircle(place, 7 * screen.scale, IM_COL32(255, 255, 255, 220), 24,
                        1.5f * screen.scale);
}

// The picked Gaussian's ellipse, square and boxes, and the inspected pixel.
void draw_inspected(const Viewer& viewer, const Screen& screen) {
  const Inspection& inspection = viewer.inspected->inspection;
  const auto rectangle = [&](glm::dvec2 low, glm::dvec2 high, ImU32 color, float width) {
    screen.draw.AddRect(screen.at(low), screen.at(high), color, 0, 0, width * screen.scale);
  };
  if (inspection.gaussian) {
    const GaussianReport& gaussian = *inspection.gaussian;
    rectangle(gaussian.square.low, gaussian.square.high, IM_COL32(255, 255, 255, 150), 1);
    rectangle(gaussian.adr.low, gaussian.adr.high, color_of(mode_color(kAdr)), 1.5f);
    for (const Box& box : gaussian.quad_boxes)
      rectangle(box.low, box.high, color_of(kSkyBlue), 1.5f);
    std::vector<ImVec2> ellipse;
    for (const glm::vec2 point : ellipse_of(gaussian.footprint, 96))
      ellipse.push_back(screen.at(point));
    screen.draw.AddPolyline(ellipse.data(), static_cast<int>(ellipse.size()), color_of(kVermillion),
                            ImDrawFlags_Closed, 2 * screen.scale);
  }
  const glm::dvec2 pixel(inspection.pixel.pixel);
  rectangle(pixel - 2.5, pixel + 2.5, IM_COL32(0, 0, 0, 255), 3);
  rectangle(pixel - 2.5, pixel + 2.5, IM_COL32(0, 200, 140, 255), 1.5f);
}

// A frame around the compared part, and a ring around the first pixel that differs from the
// reference.
void draw_verdict_marks(const Viewer& viewer, const Screen& screen) {
  const ReferenceCheck& verdict = viewer.comparison->verdict;
  const PixelBox& box = verdict.region;
  if (box.x1 - box.x0 < viewer.camera.width || box.y1 - box.y0 < viewer.camera.height)
    screen.draw.AddRect(screen.at(glm::dvec2(box.x0, box.y0) - 0.5),
                        screen.at(glm::dvec2(box.x1, box.y1) - 0.5), IM_COL32(255, 255, 255, 200),
                        0, 0, 1.5f * screen.scale);
  if (!verdict.difference.first) return;
  const ImVec2 at = screen.at(glm::dvec2(*verdict.difference.first));
  screen.draw.AddCircle(at, 12 * screen.scale, IM_COL32(0, 0, 0, 200), 32, 4 * screen.scale);
  screen.draw.AddCircle(at, 12 * screen.scale, ImGui::GetColorU32(palette::kError), 32,
                        2 * screen.scale);
}

}  // namespace

void draw_overlay(const Viewer& viewer, const PanelState& state, Floats& floats, Actions& actions) {
  if (!viewer.scene || viewer.shown.grid) return;
  const Screen screen{viewer.camera, floats.picture(), *ImGui::GetBackgroundDrawList(),
                      drawing_scale()};
  const auto [low, high] = screen.area;
  screen.draw.PushClipRect({low.x, low.y}, {high.x, high.y});
  if (viewer.panels.photograph && viewer.dataset_camera >= 0)
    draw_photograph(viewer, state, screen, floats, actions);
  if (viewer.panels.frusta) {
    const double depth = 0.06 * viewer.scene->extent();
    for (std::size_t i = 0; i < viewer.scene->cameras.size(); ++i) {
      if (static_cast<int>(i) == viewer.dataset_camera) continue;  // the view is inside it
      draw_frustum(screen, viewer.scene->cameras[i], depth, color_of(kSkyBlue, 0.745f), 1);
    }
  }
  if (viewer.panels.inspector && viewer.inspected && viewer.inspected->version == viewer.version)
    draw_inspected(viewer, screen);
  if (viewer.panels.crop && viewer.crop.wish.boxed) draw_crop_box(viewer, screen, actions);
  for (const PictureLine& line : shape_lines(viewer))
    for (const auto& [color, width] :
         {std::pair(ImU32{IM_COL32(0, 0, 0, 160)}, 3.0f), std::pair(color_of(kVermillion), 1.5f)})
      screen.draw.AddLine(screen.at(line.from), screen.at(line.to), color, width * screen.scale);
  if (viewer.panels.measures) draw_rulers(viewer, screen);
  if (viewer.cross) draw_cross(screen, *viewer.cross);
  if (verdict_is_current(viewer)) draw_verdict_marks(viewer, screen);
  if (viewer.moving() && viewer.navigation == Navigation::orbit) draw_pivot(viewer, screen);
  screen.draw.PopClipRect();
}

void draw_verdict(const Viewer& viewer, Actions& actions) {
  if (!verdict_is_current(viewer)) return;
  const std::optional<glm::ivec2>& pixel = viewer.comparison->verdict.difference.first;
  const Rect picture = current_layout(viewer).picture;
  ImGui::SetNextWindowPos({picture.low.x + 10, picture.high.y - 10}, ImGuiCond_Appearing, {0, 1});
  bool open = true;
  ImGui::Begin("Reference", &open,
               ImGuiWindowFlags_NoNav | ImGuiWindowFlags_NoFocusOnAppearing |
                   ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoCollapse);
  for (const Fact& fact : verdict_facts(*viewer.comparison)) {
    ImGui::TextColored(palette::kFaint, "%s", fact.label.c_str());
    ImGui::SameLine(7 * ImGui::GetFontSize());
    const bool failed = pixel && fact.label == "verdict";
    ImGui::TextColored(failed ? palette::kError : palette::kText, "%s", fact.value.c_str());
  }
  if (pixel && ImGui::Button("Inspect this pixel")) {
    if (!viewer.panels.inspector) actions.push_back(call(action::toggle_panel, &Panels::inspector));
    actions.push_back(call(action::inspect_pixel, glm::dvec2(*pixel)));
  }
  ImGui::End();
  if (!open) actions.push_back(call(action::dismiss_comparison));
}

}  // namespace qs
