// SPDX-License-Identifier: MIT
//
// The look of the panels: a dark and a light theme, and one font size.
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

// The theme in use: apply_style() sets it.
inline bool is_light = false;
inline ImVec4 tones[6];
inline const ImVec4 &kPanel = tones[0], &kText = tones[1], &kFaint = tones[2], &kAccent = tones[3],
                    &kCaution = tones[4], &kError = tones[5];

inline ImVec4 with_opacity(const Ink& ink, float opacity = 1) {
  return with_opacity(is_light ? ink.light : ink.dark, opacity);
}
inline ImVec4 text_of(const Ink& ink) {
  return with_opacity(is_light ? on_white::for_text(ink.light) : ink.dark);
}
}  // namespace palette

/// For draw lists.
template <class Color>
ImU32 color_of(const Color& color, float opacity = 1) {
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

/// Sets the theme, and ImGui's style for `scale` pixels per unit.
void apply_style(float scale, bool is_light = false);

}  // namespace qs
