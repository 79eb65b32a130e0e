// SPDX-License-Identifier: MIT
//
// The statistics of rendered frames as JSON, with everything needed to judge or repeat them:
//   {"environment": {...}, "scene": {...}, "view_count": 97,
//    "frames": [{view, mode, pairs, times, camera, ...}, ...]}
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "app/measure/measure.h"
#include "app/session/session.h"
#include "app/session/shot.h"

namespace qs {

/// What a report says about build, machine and backend, and about the scene.
nlohmann::ordered_json environment_json(const Session& session);
nlohmann::ordered_json scene_json(const Scene& scene);

struct FrameRecord {
  Shot shot;
  std::size_t view = 0;  ///< number of the shot in the sweep, the same in every shard
  ModeResult result;
  std::string picture;                   ///< file, empty when none was written
  std::optional<double> reference_psnr;  ///< dB against --reference
};

/// `view_count`: of the sweep, shards not rendered here included.
std::string format_stats(const Session& session, const std::vector<FrameRecord>& frames,
                         std::size_t view_count);

/// To a file, or to stdout for "-". Throws Error(input).
void write_stats(const std::filesystem::path& path, const std::string& text);

}  // namespace qs
