// SPDX-License-Identifier: MIT
//
// Draws plots with gnuplot. Every plot is a script NAME.gp with its data inside, saved beside
// NAME.png and NAME.svg, so that anybody can change and redraw it: `gnuplot NAME.gp` in its folder.
// Colours are Okabe and Ito's, which colour-blind people tell apart; a mode keeps its colour and
// its marker in every plot.
#pragma once

#include <filesystem>
#include <span>
#include <string>

namespace qs {

struct Plot {
  std::string name;  ///< file name without extension
  std::string title, caption;
  std::string commands;  ///< gnuplot: data blocks, axes and one plot command, which ends it
};

/// Writes the scripts and runs gnuplot. Returns an empty text, or one sentence that says how to
/// draw the plots because gnuplot is missing or failed. Throws Error when a script cannot be
/// written.
std::string draw_plots(const std::filesystem::path& folder, std::span<const Plot> plots);

/// Number of the gnuplot point type that marks a mode's curve.
int mode_marker(const std::string& mode);

/// A gnuplot string literal.
std::string quoted(const std::string& text);

}  // namespace qs
