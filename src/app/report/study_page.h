// SPDX-License-Identifier: MIT
//
// A study as an HTML page for readers who do not know this program, and its plots, see plot.h.
#pragma once

#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "app/report/plot.h"
#include "app/report/scene_study.h"

namespace qs {

/// Their names: "uses", "sizes", "loads", and for every quantity "count_KEY" and "saved_KEY".
std::vector<Plot> study_plots(const SceneStudy& study, const std::string& caption);

/// "1.25-1.5", "20+", "<1.25": the label of a bin.
std::string bin_label(const GaussianQuantity& quantity, std::size_t bin);

struct CaptionedImage {
  Image image;
  std::string caption;
};

struct StudyPage {
  const SceneStudy& study;
  std::string scene;                     ///< the scene's name
  std::string views;                     ///< "camera 0, camera 24, 1600 x 1200 pixels"
  std::string plots;                     ///< caption: "plush, 4 views, 1600 x 1200 pixels"
  std::vector<CaptionedImage> pictures;  ///< pictures of the first view
  std::vector<CaptionedImage> example;   ///< pictures of study.example; may be empty
  std::string made_with;                 ///< sentences about program, machine and time
};

/// The page as one HTML file. Plots are drawn with gnuplot. If that fails, the page says so and has
/// tables instead, and `problem` is set to one sentence; otherwise to "".
std::string format_study_page(const StudyPage& page, std::string& problem);

}  // namespace qs
