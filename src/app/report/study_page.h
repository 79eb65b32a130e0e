// SPDX-License-Identifier: MIT
//
// A study as an HTML page for readers who do not know this program.
#pragma once

#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "app/report/scene_study.h"

namespace qs {

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
