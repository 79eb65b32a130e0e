// SPDX-License-Identifier: MIT
//
// The sections of the state for the panels that a visitor has opened, and for what is drawn over
// the picture. The window's panels have the same words and numbers; nothing else is sent.
#pragma once

#include <nlohmann/json.hpp>

#include "app/serve/visitor.h"

namespace qs {

/// Section -> value; null for what is closed or of no use now. All sections are always there.
///
///   panels     which panels there are and are open: [{name, title, key, open}]
///   controls   of the open panels and their lists, by the panel's name
///   table      the table of modes            inspector  the clicked pixel
///   split      names and facts of a split    recorder   the zoom recorder with its chart
///   grid       the labels of all modes       crop       its words, and the box in the picture
///   path       the cameras and keyframes     facts      of the scene
///   job        what runs for this visitor    status     the line below the picture
///   training   the run whose model is shown
nlohmann::json panel_sections(const Visitor& visitor);

/// The colours and meanings of the modes and of the stages, which do not change.
nlohmann::json legend_json();

/// The text without paths of files: the scene's path becomes its name, other paths their last part.
std::string public_text(const Viewer& viewer, std::string text);

}  // namespace qs
