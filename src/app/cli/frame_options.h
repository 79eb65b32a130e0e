// SPDX-License-Identifier: MIT
//
// Command-line options that all rendering commands share.
#pragma once

#include <string>

#include "app/cli/options.h"
#include "app/session/session.h"

namespace qs {

/// Declares SCENE and the common options.
void declare_frame_options(Options& options, FrameOptions& frame);

/// Declares the common options without SCENE, for commands that take several scenes.
void declare_common_options(Options& options, FrameOptions& frame);

/// Declares --axes.
void declare_axes_option(Options& options, std::string& axes);

}  // namespace qs
