// SPDX-License-Identifier: MIT
//
// The words and numbers of the performance panel (heads-up display) and of the split window's
// facts, apart from their drawing, so that tests can compare them with the CSV of the same
// measurement.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "app/measure/statistics.h"
#include "app/viewer/state/mode_table.h"
#include "app/viewer/state/panel_text.h"

namespace qs {

/// A sentence with the number of frames behind the numbers of the table.
std::string hud_status(const Viewer& viewer);

/// Facts of the frame in the window.
std::vector<Fact> hud_facts(const Viewer& viewer);

/// The line below the picture: the numbers of the frame in the window, and at its right end a
/// caveat about them, or a hint to more numbers.
struct StatusLine {
  std::string numbers, note;
  bool faint = false;    ///< the numbers are of a reduced frame
  bool caution = false;  ///< the note gives the reason why the numbers are not a measurement
};
StatusLine status_line(const Viewer& viewer);

/// The lines of the badge below the mode's name, of the picture in the window at its own size: FPS
/// if they are known, pairs, size and backend.
std::vector<std::string> badge_lines(const Viewer& viewer);

/// "filming, 31 % - plush (splat scale 0.56) - quadsplat".
std::string window_title(const Viewer& viewer);

/// Facts of the two frames in a split window; empty otherwise.
std::vector<Fact> split_facts(const Viewer& viewer);

/// "drawn at 1/2 size, with a heat map: not a measurement"; empty if nothing hinders the frame.
std::string hud_caveat(const Viewer& viewer);

/// Milliseconds per stage; index = Stage. The text has a line per stage.
std::array<double, kStageCount> stages_of(const BenchRow& row);
std::string stages_text(const BenchRow& row);

/// The caption of the plot of Viewer::frame_ms, which must not be empty.
std::string frame_plot_text(const Viewer& viewer);

/// "\u22121,234", "+5".
std::string signed_text(std::int64_t number);

/// The content of the window as JSON, for tests and for reports of problems.
std::string state_json(const Viewer& viewer);

}  // namespace qs
