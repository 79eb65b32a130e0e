// SPDX-License-Identifier: MIT
//
// A checkpoint: a training run that continues to the same bits. The file is little endian:
//   "QSTRAIN6", u64 bytes of a JSON object (settings, data, log, sizes), the object, then the
//   arrays of parameters and of both moments, the density statistics, the values and moments of a
//   colour field, and a u64 FNV-1a hash of all bytes before it.
#pragma once

#include <filesystem>
#include <string>

#include "learn/run/settings.h"
#include "learn/run/train_log.h"
#include "learn/step/model_state.h"

namespace qs::train {

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

}  // namespace qs::train
