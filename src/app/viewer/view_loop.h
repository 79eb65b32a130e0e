// SPDX-License-Identifier: MIT
//
// The viewer's loop on the main thread: input -> actions -> state -> orders for the render thread
// -> frames -> window. When nothing happens it sleeps.
#pragma once

#include <filesystem>
#include <optional>

#include "app/session/session.h"

namespace qs {

struct ViewOptions {
  FrameOptions frame;                 ///< scene empty: an empty window
  std::optional<std::string> beside;  ///< find_variant(): splits the window from the start
  bool vsync = true, interop = true;
  std::filesystem::path settings;               ///< preferences file; empty: nothing is remembered
  std::optional<std::filesystem::path> script;  ///< input script, see input_script.h
  std::filesystem::path out_dir = ".";          ///< screenshots, zooms and benches go below it
};

/// Opens the window and stays until it is closed. Throws Error.
void run_viewer(const ViewOptions& options);

}  // namespace qs
