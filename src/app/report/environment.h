// SPDX-License-Identifier: MIT
//
// The environment of reports: build, machine, backend, scene, the clock of the GPU, and plugins.
//   "gpu_clock": {"readings": 31, "sm_mhz": {"median": 1980.0, "min": 1980.0, "max": 1980.0},
//                 "sm_mhz_max": 1980.0, "throttled": [], "celsius": {...}, "watts": {...}},
//   "gpu_clock_text": ["NVIDIA H200: SM clock 1,980 MHz, not throttled"]
// Unknown values of the clock are null, and so is "gpu_clock" without any reading. A warning is a
// second line of the text. Reports of the CPU backend have neither.
//   "plugins": ["`own`: a description (libown.so, crc32:89abcdef). Its times are ..."],
//   "plugin_problems": ["plush, camera 3: plugin own: crashed with signal 11 while rendering"]
// Reports without plugins have neither. A merged report has a list of the parts' values of
// "gpu_clock", and every line of their other lists once.
#pragma once

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "app/measure/measure.h"
#include "app/session/session.h"
#include "app/session/shot.h"
#include "raster/clock/gpu_clock.h"

namespace qs {

/// Build, machine and backend, as reports contain them.
nlohmann::ordered_json environment_json(const Session& session);

/// File, hash, size and alterations of the session's scene.
nlohmann::ordered_json scene_json(const Session& session);

struct FrameRecord {
  Shot shot;
  std::size_t view = 0;  ///< number of the shot, the same in every shard
  ModeResult result;
  std::string picture;                   ///< path of the written file, or ""
  std::optional<double> reference_psnr;  ///< dB against --reference
};

/// The statistics of rendered frames as JSON, with everything needed to repeat them:
///   {"environment": {...}, "scene": {...}, "view_count": 97,
///    "frames": [{view, mode, pairs, times, camera, ...}, ...]}
/// `view_count`: number of shots in all shards.
std::string format_stats(const Session& session, const std::vector<FrameRecord>& frames,
                         std::size_t view_count);

/// A clock for measurements with this session; without sensors on the CPU backend.
GpuClock clock_of(const Session& session);

/// Adds both members to an environment_json() of the CUDA backend.
void add_clock(nlohmann::ordered_json& environment, const GpuClock& clock);

/// The lines of "gpu_clock_text"; empty without it.
std::vector<std::string> clock_lines(const nlohmann::ordered_json& environment);

struct PluginFacts {
  std::string name, description;
  std::string file;  ///< name and hash of the library
  bool measures_itself = false;
  bool on_device = false;  ///< its scene and image are in CUDA's memory
  std::string scene;       ///< scene on which call_factor was measured
  double call_factor = 1;  ///< time of its calls by the host's clock / its own times
};

/// One line of "plugins".
std::string plugin_line(const PluginFacts& facts);

/// Appends a line to the list `key` of an environment unless it has it.
void add_line(nlohmann::ordered_json& environment, const char* key, const std::string& line);

/// The lines below the tables: the scope, the plugins, and a list of the problems. Markdown; empty
/// without plugins.
std::string plugin_markdown(const nlohmann::ordered_json& environment);

/// Sets the clocks and plugins of a merged report from the environments of its parts.
void merge_environments(const std::vector<nlohmann::ordered_json>& parts,
                        nlohmann::ordered_json& environment);

}  // namespace qs
