// SPDX-License-Identifier: MIT
//
// The settings of a training run. Two runs with equal settings and data give the same model to the
// bit.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <glm/vec3.hpp>
#include <nlohmann/json_fwd.hpp>

#include "learn/run/pace.h"
#include "raster/kernel/cull/mode.h"
#include "raster/scene/gaussian_cloud.h"

namespace qs::train {

/// The statistics of density control count a view for the Gaussians that one mode lists in a tile:
/// mode `exact`, or the mode of the training frames, as in published code.
enum class CountViews { exact, mode };
inline constexpr const char* kCountViewsNames[] = {"exact", "mode"};  ///< in their order

struct TrainSettings {
  int iterations = 30'000;
  std::string strategy = "adc";
  CullMode mode = default_mode();
  std::uint64_t seed = 0;
  int sh_degree = kMaxShDegree;
  bool antialiased = false;
  glm::vec3 background{0};              ///< RGB, 0..1
  bool random_background = false;       ///< another colour in every iteration
  std::size_t max_gaussians = 0;        ///< 0: the strategy's own limit
  bool many_gaussians = false;          ///< `fastgs`: more Gaussians, for quality
  bool absolute_gradients = false;      ///< `adc`: splits by absolute gradients
  bool sum_gradients = false;           ///< `fastgs`: later steps use sums of gradients
  bool final_prunes = false;            ///< `adc`, `mcmc`: see final_prune_after()
  bool reduced_photographs = false;     ///< reduced at first, see ResolutionSchedule
  bool color_field = false;             ///< `mask`: colours of a field, not spherical harmonics
  bool dash_of_paper = false;           ///< `dash` as of June 2025, which the paper used
  std::size_t random_points = 100'000;  ///< to start from if the data set has no points
  CountViews count_views = CountViews::exact;
  bool step_before_densify = false;  ///< the step before Gaussians are added is taken
  bool published_extent = false;     ///< see DataSet::published_extent
  double opacity_rate = 0;           ///< learning rate of opacity logits; 0: the strategy's own
  double seconds = 0;           ///< `paced`: the time of the run, which corrects its pace; 0: none
  bool guard = false;           ///< `paced`: some training views are reserved, see guard.h
  std::vector<Pace::Row> pace;  ///< `paced`: of another run; empty: of `iterations`

  /// The iteration from which the resolution schedule has full size.
  int reduced_until() const { return static_cast<int>(9L * iterations / 10); }

  bool depends_on_end() const {
    return reduced_photographs || strategy == "dash" || strategy == "paced";
  }

  Pace given_pace() const { return pace.empty() ? Pace(iterations) : Pace(pace); }

  bool white() const { return !random_background && background == glm::vec3(1); }
};

/// As a JSON object, and back. settings_of() throws nlohmann::json::exception.
nlohmann::ordered_json settings_json(TrainSettings settings);
TrainSettings settings_of(const nlohmann::ordered_json& json);

/// Rows of a pace as pairs [from, iterations], and back. pace_of() throws
/// nlohmann::json::exception, and Error(input) for rows that are no pace.
nlohmann::ordered_json pace_json(const std::vector<Pace::Row>& rows);
std::vector<Pace::Row> pace_of(const nlohmann::ordered_json& json);

/// The names of the settings that differ, except `iterations` and `max_gaussians`: a resumed run
/// may end later, and may have less memory, unless its schedules depend on that.
std::string differences_of(const TrainSettings& a, const TrainSettings& b);

}  // namespace qs::train
