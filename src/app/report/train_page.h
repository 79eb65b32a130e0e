// SPDX-License-Identifier: MIT
//
// The course of a training run as plots and as a page: loss, quality on the test views and number
// of Gaussians over the iterations.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "app/report/plot.h"
#include "learn/run/settings.h"
#include "learn/run/train_log.h"

namespace qs::train {

/// Empty without rows. The plot of the quality is left out if nothing was evaluated.
std::vector<Plot> train_plots(const TrainLog& log, const std::string& caption);

/// Writes the plots into the folder `plots` of a model folder, and the page train.html with the
/// same plots and the evaluations as a table. Returns "", or one sentence if gnuplot is missing.
/// Throws Error(input).
std::string write_train_page(const std::filesystem::path& folder, const TrainSettings& settings,
                             const TrainLog& log);

}  // namespace qs::train
