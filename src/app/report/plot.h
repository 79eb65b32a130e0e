// SPDX-License-Identifier: MIT
//
// Draws plots with gnuplot. Every plot is a script NAME.gp that contains its data. It is saved next
// to NAME.png and NAME.svg, so that it can be edited and drawn again with `gnuplot NAME.gp`.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include <glm/vec3.hpp>

namespace qs {

struct Plot {
  std::string name;  ///< file name without extension
  std::string title, caption;
  std::string commands;      ///< gnuplot: data blocks, axes, and at the end one plot_command()
  std::string altered = {};  ///< a line below the caption; usually empty
};

/// Writes the scripts and runs gnuplot. Returns "", or one sentence with instructions for drawing
/// the plots in `shown`, the folder's final name, if gnuplot is missing or fails. Throws Error when
/// a script cannot be written.
std::string draw_plots(const std::filesystem::path& folder, std::span<const Plot> plots,
                       const std::filesystem::path& shown = {});

/// A gnuplot string literal.
std::string quoted(const std::string& text);

/// Defines the data block $NAME; each line is a row.
std::string data_block(const std::string& name, const std::vector<std::string>& lines);

/// The gnuplot command that draws all curves in one plot.
std::string plot_command(const std::vector<std::string>& curves);

/// `linecolor rgb "#0072B2"`.
std::string color_option(glm::vec3 color);
std::string mode_color_option(const std::string& mode);

/// `linecolor rgb "#0072B2" title "quadbox"`: the mode's colour and the curve's title.
std::string mode_options(const std::string& mode, const std::string& title);

/// Number of the gnuplot point type that marks a mode's curve.
int mode_marker(const std::string& mode);

/// Colour, title and point type of the plugin with this number, 0 or more.
std::string plugin_options(std::size_t number, const std::string& title);
int plugin_marker(std::size_t number);

}  // namespace qs
