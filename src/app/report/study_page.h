// SPDX-License-Identifier: MIT
//
// A study as a page that explains itself to a reader who knows nothing of this program.
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
  std::string scene;                     ///< its name
  std::string views;                     ///< "camera 0, camera 24, 1600 x 1200 pixels"
  std::string plots;                     ///< of each plot: "plush, 4 views, 1600 x 1200 pixels"
  std::vector<CaptionedImage> pictures;  ///< of the first view
  std::vector<CaptionedImage> telling;   ///< of study.telling; may be empty
  std::string made_with;                 ///< program, machine, time
};

/// HTML in one file. Draws the plots with gnuplot; where that fails, the page has the tables only,
/// and says so. `problem`: that sentence, "" when all went well.
std::string format_study_page(const StudyPage& page, std::string& problem);

}  // namespace qs
