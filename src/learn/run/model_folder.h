// SPDX-License-Identifier: MIT
//
// Writes a trained model as a folder that view, eval, bench and other programs open:
//   point_cloud/iteration_N/point_cloud.ply   the Gaussians
//   cameras.json, cfg_args, input.ply         as the published trainer writes them
//   train.json, train.csv                     settings, environment and result; the log
//   train.html, plots                         the log as plots, see train_page.h
//   checkpoint                                continues an unfinished run, see Checkpoint
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "io/bytes/replace_file.h"
#include "learn/run/data_set.h"
#include "learn/run/settings.h"
#include "learn/run/train_log.h"
#include "learn/step/model_state.h"

namespace qs::train {

// A checkpoint: a training run that continues to the same bits. The file is little endian:
//   "QSTRAIN6", u64 bytes of a JSON object (settings, data, log, sizes), the object, then the
//   arrays of parameters and of both moments, the density statistics, the values and moments of a
//   colour field, and a u64 FNV-1a hash of all bytes before it.

struct Checkpoint {
  TrainSettings settings;
  std::string data;  ///< DataSet::fingerprint()
  TrainLog log;
  ModelState model;
};

/// References to the same values, because a copy of the model may not fit into memory.
struct CheckpointView {
  const TrainSettings& settings;
  const std::string& data;
  const TrainLog& log;
  const ModelState& model;
};

/// Needs no memory for the model. The file appears whole or not at all. Throws Error(input).
void write_checkpoint(const CheckpointView& checkpoint, const std::filesystem::path& path);

/// Throws Error(input) if the file is missing or damaged.
Checkpoint read_checkpoint(const std::filesystem::path& path);

/// Removes the file if it is a checkpoint.
void remove_checkpoint(const std::filesystem::path& path);

/// The pace that a run with TrainSettings::seconds recorded in its train.json. Throws Error(input).
std::vector<Pace::Row> read_pace(const std::filesystem::path& train_json);

/// Creates the folder with cameras.json, cfg_args and input.ply. Throws Error(input).
void write_model_start(const std::filesystem::path& folder, const TrainSettings& settings,
                       const DataSet& data);

/// Writes the Gaussians, which count from `origin`. Returns their path.
std::filesystem::path write_gaussians(const std::filesystem::path& folder,
                                      const TrainSettings& settings, const ModelState& model,
                                      const glm::dvec3& origin, ThreadPool& pool);

/// Locks the folder of a model, which exists, against other runs. Throws Error(usage) if another
/// run trains into it.
FolderLock lock_model_folder(const std::filesystem::path& folder);

/// Writes the state: Gaussians, log and checkpoint. `backend` is for the log. The last state of a
/// run has no checkpoint, and an earlier one is removed. Returns the path of the Gaussians.
std::filesystem::path write_model_state(const std::filesystem::path& folder,
                                        const CheckpointView& checkpoint, const DataSet& data,
                                        const std::string& backend, ThreadPool& pool, bool last);

/// The iterations of earlier runs in a model folder, by number.
struct OldIterations {
  std::vector<int> removed, foreign;  ///< `foreign`: this program did not train them, so they stay
};

/// Removes the Gaussians of earlier runs that this program trained, and their folders if these hold
/// nothing else. Throws Error(usage) if the command reads a file that would go.
OldIterations remove_old_iterations(const std::filesystem::path& folder);

/// The file of the Gaussians after an iteration.
std::filesystem::path gaussians_path(const std::filesystem::path& folder, int iteration);

std::filesystem::path checkpoint_path(const std::filesystem::path& folder);

}  // namespace qs::train
