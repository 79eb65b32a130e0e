// SPDX-License-Identifier: MIT
//
// The commands for a training run.
#pragma once

namespace qs {

/// A user gives the commands after `go_on`. A watcher of the run (train/run.h) carries out `pause`,
/// `resume` and `step` itself, and asks the run to `go_on`, `save` or `stop`.
enum class TrainingCommand { go_on, pause, resume, step, save, stop };

}  // namespace qs
