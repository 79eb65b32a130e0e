// SPDX-License-Identifier: MIT
//
// The look of the panels: a dark palette and one font size.
#pragma once

#include <cstdint>
#include <string>

#include <imgui.h>

#include "app/picture/palette.h"

namespace qs {

inline constexpr float kFontSize = 15;  ///< units of the screen

namespace palette {
inline ImVec4 with_opacity(glm::vec3 color, float opacity = 1) {
  return {color.r, color.g, color.b, opacity};
}
inline const ImVec4 kPanel = with_opacity(on_dark::kPanel);
inline const ImVec4 kText = with_opacity(on_dark::kText);
inline const ImVec4 kFaint = with_opacity(on_dark::kFaint);
inline const ImVec4 kAccent = with_opacity(kSkyBlue);
inline const ImVec4 kCaution = with_opacity(kOrange);
inline const ImVec4 kError{0.90f, 0.36f, 0.22f, 1};  ///< vermillion, lightened
}  // namespace palette

/// For draw lists.
inline ImU32 color_of(glm::vec3 color, float opacity = 1) {
  return ImGui::GetColorU32(palette::with_opacity(color, opacity));
}

/// Text in lines as wide as the panel.
inline void draw_wrapped(const ImVec4& color, const std::string& text) {
  ImGui::PushStyleColor(ImGuiCol_Text, color);
  ImGui::TextWrapped("%s", text.c_str());
  ImGui::PopStyleColor();
}

/// ImGui's name of a GL texture.
inline ImTextureID texture_id(unsigned texture) {
  return reinterpret_cast<ImTextureID>(static_cast<std::uintptr_t>(texture));
}

/// A window without decoration that never takes the keyboard.
inline constexpr ImGuiWindowFlags kBareWindow =
    ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoNav | ImGuiWindowFlags_NoFocusOnAppearing;

/// True in the frame in which the key goes down, and while it repeats.
inline bool pressed(ImGuiKey key) { return ImGui::IsKeyPressed(ImGui::GetKeyIndex(key)); }

/// pressed() of both keys named Enter. Dear ImGui 1.87 renamed the key of the number block.
inline bool enter_pressed() {
#if IMGUI_VERSION_NUM >= 18700
  return pressed(ImGuiKey_Enter) || pressed(ImGuiKey_KeypadEnter);
#else
  return pressed(ImGuiKey_Enter) || pressed(ImGuiKey_KeyPadEnter);
#endif
}

/// Factor on the lengths and widths of lines that are drawn over the picture: the size of letters
/// over kFontSize.
float drawing_scale();

/// Sets ImGui's style for `scale` pixels per unit.
void apply_style(float scale);

}  // namespace qs
