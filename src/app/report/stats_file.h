// SPDX-License-Identifier: MIT
//
// The statistics of rendered frames as JSON, with everything needed to repeat them:
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

/// Build, machine and backend, as reports contain them.
nlohmann::ordered_json environment_json(const Session& session);

/// File, hash and size of a scene.
nlohmann::ordered_json scene_json(const Scene& scene);

struct FrameRecord {
  Shot shot;
  std::size_t view = 0;  ///< number of the shot, the same in every shard
  ModeResult result;
  std::string picture;                   ///< path of the written file, or ""
  std::optional<double> reference_psnr;  ///< dB against --reference
};

/// `view_count`: number of shots in all shards.
std::string format_stats(const Session& session, const std::vector<FrameRecord>& frames,
                         std::size_t view_count);

}  // namespace qs
