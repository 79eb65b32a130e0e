// SPDX-License-Identifier: MIT
//
// The words and numbers of the heads-up display, apart from its drawing, so that tests can compare
// them with the CSV of the same measurement.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "app/viewer/state/viewer.h"

namespace qs {

/// One mode of the table; "-" where nothing was measured yet.
struct HudRow {
  CullMode mode = 0;
  std::string name, ms, fps, pairs, per_visible, in_vain, speedup;
  std::string other_ms, other_speedup;  ///< of the other pipeline; empty where there is one only
};

/// Titles of HudRow's texts.
inline constexpr const char* kHudColumns[] = {"mode",        "ms",      "FPS",    "pairs",
                                              "per visible", "in vain", "vs 3dgs"};

std::vector<HudRow> hud_rows(const Viewer& viewer);

/// The pipeline whose numbers stand beside those of the one on show; empty on a backend with one.
std::optional<Pipeline> other_pipeline(const Viewer& viewer);

/// The row of a mode in the pipeline on show, or in another; null when it was not measured.
const BenchRow* measured_row(const Viewer& viewer, CullMode mode, Pipeline pipeline);

/// Are the rows of the view in the window? They may be of an earlier one while they are measured.
bool numbers_are_current(const Viewer& viewer);

/// A label and its value.
struct HudFact {
  std::string label, value;
};
/// Of the frame in the window.
std::vector<HudFact> hud_facts(const Viewer& viewer);

/// Of the two frames in a split window; none in another one.
std::vector<HudFact> split_facts(const Viewer& viewer);

/// "drawn on demand, with a heat map: not a measurement"; empty when it is one.
std::string hud_caveat(const Viewer& viewer);

/// Milliseconds with three digits after the point; FPS with one below 1000.
std::string ms_text(double ms);
std::string fps_text(double fps);

/// "-1,234", "+5".
std::string signed_text(std::int64_t number);

/// Everything above as JSON, for tests and for people who report problems.
std::string state_json(const Viewer& viewer);

}  // namespace qs
