// SPDX-License-Identifier: MIT
//
// Command-line options that several commands share.
#pragma once

#include <string>

#include "app/cli/options.h"
#include "app/measure/shard.h"
#include "app/session/session.h"

namespace qs {

/// Samples of a scene argument.
inline const Options::Samples kSceneSamples = {"scene.ply", "model"};

/// Declares SCENE and the options of declare_common_options().
void declare_frame_options(Options& options, FrameOptions& frame);

/// Declares the options of every rendering command, without SCENE.
void declare_common_options(Options& options, FrameOptions& frame);

/// Declares --axes.
void declare_axes_option(Options& options, std::string& axes);

/// Declares --shard for a Shard or a std::optional<Shard>.
template <class T>
void declare_shard_option(Options& options, T& shard, const std::string& help) {
  options.value("--shard", "I/N", help + "; see quadsplat merge", {"1/1", "2/2"},
                [&shard](const std::string& text) { shard = parse_shard("--shard", text); });
}

}  // namespace qs
