// SPDX-License-Identifier: MIT
//
// The look of the panels: a dark palette and one font size.
#pragma once

#include <imgui.h>

namespace qs {

inline constexpr float kFontSize = 15;  ///< units of the screen

namespace palette {
inline const ImVec4 kPanel{0.085f, 0.09f, 0.105f, 0.93f};
inline const ImVec4 kText{0.90f, 0.91f, 0.92f, 1};
inline const ImVec4 kFaint{0.60f, 0.62f, 0.65f, 1};
inline const ImVec4 kAccent{0.34f, 0.71f, 0.91f, 1};   ///< sky blue
inline const ImVec4 kCaution{0.90f, 0.62f, 0.00f, 1};  ///< orange
inline const ImVec4 kError{0.90f, 0.36f, 0.22f, 1};    ///< vermillion
/// Index = Stage: blue, orange, green, purple (Okabe and Ito's colours for dark backgrounds).
inline const ImVec4 kStages[] = {{0.34f, 0.71f, 0.91f, 1},
                                 {0.90f, 0.62f, 0.00f, 1},
                                 {0.00f, 0.62f, 0.45f, 1},
                                 {0.80f, 0.47f, 0.65f, 1}};
}  // namespace palette

/// Sets ImGui's style for `scale` pixels per unit.
void apply_style(float scale);

}  // namespace qs
