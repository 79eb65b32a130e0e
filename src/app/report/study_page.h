// SPDX-License-Identifier: MIT
//
// A study as an HTML page for readers who do not know this program, and its plots, see plot.h.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "app/inspect/gaussian.h"
#include "app/inspect/pixel.h"
#include "app/report/plot.h"
#include "raster/kernel/cull/table.h"

namespace qs {

// The cost of the views of a scene: the visible Gaussians, the pairs that each mode saves on them,
// the uses of the pairs and their distribution over the tiles, for several tile sizes. All numbers
// are sums over the views; study_page presents them. To add a quantity by which Gaussians are
// grouped: a row in kGaussianQuantities.

/// A property of a visible Gaussian. Bin i holds values in [edges[i], edges[i + 1]); the first and
/// last bin also hold smaller and larger values.
struct GaussianQuantity {
  const char* name;   ///< the name in titles
  const char* key;    ///< the name in file names
  const char* unit;   ///< "" for a dimensionless number
  const char* means;  ///< one sentence for the page
  std::array<double, 13> edges;
  double (*of)(const Footprint& footprint, const Splat& splat);
};

std::span<const GaussianQuantity> quantities();
inline constexpr std::size_t kBins = 12;
inline constexpr std::size_t kUsualSize = 1;  ///< index of kTileSize in kTileSizes

inline constexpr int kStudyFrames = 5;  ///< timed frames per mode and view

/// Index of the bin that holds `value`.
std::size_t bin_of(const GaussianQuantity& quantity, double value);

/// The visible Gaussians, grouped by one quantity.
struct BinnedPairs {
  std::array<std::uint64_t, kBins> gaussians{};
  /// Pairs of the bin's Gaussians, [mode - 1][bin].
  std::array<std::array<std::uint64_t, kBins>, kCullerCount> pairs{};
};

/// A mode at one tile size.
struct ModeStudy {
  std::uint64_t pairs = 0;  ///< the number that the renderer counts
  PairUses uses;
  std::vector<std::uint32_t> loads;  ///< pairs of all tiles of all views, ascending
};

struct SceneStudy {
  std::size_t views = 0;
  std::uint64_t gaussians = 0;  ///< number of Gaussians in the cloud
  std::uint64_t huge = 0;       ///< number of Gaussians that are larger than the scene
  std::uint64_t visible = 0;    ///< number of visible Gaussians in mode 3dgs, summed over the views
  std::vector<BinnedPairs> binned;  ///< parallel to quantities()
  std::array<std::array<ModeStudy, kCullerCount>, kTileSizes.size()> modes;  ///< [size][mode - 1]
  /// Milliseconds of a frame in tiles of the usual size: the mean over the views of the median of
  /// kStudyFrames interleaved frames. Index = CullMode - 1.
  std::array<double, kCullerCount> frame_ms{};
  /// The Gaussian on which `quadbox` saves most pairs compared with `adr`, among the Gaussians
  /// whose boxes are inside the image and small enough for a drawing.
  struct Example {
    std::size_t view = 0;
    std::uint32_t gaussian = 0;
    std::array<std::uint32_t, kCullerCount> pairs{};  ///< index = CullMode - 1
    std::uint32_t saved = 0;                          ///< 0 if no Gaussian was found
  } example;
};

/// Renders every view in every mode and tile size. `cpu`: a CPU renderer with the scene. Mode and
/// tile size of `settings` are ignored. Throws Cancelled.
SceneStudy study_scene(Renderer& cpu, std::span<const Camera> views, RenderSettings settings,
                       ThreadPool& pool, const Progress& progress);

/// Their names: "uses", "sizes", "loads", and for every quantity "count_KEY" and "saved_KEY".
std::vector<Plot> study_plots(const SceneStudy& study, const std::string& caption);

/// "1.25-1.5", "20+", "<1.25": the label of a bin.
std::string bin_label(const GaussianQuantity& quantity, std::size_t bin);

struct CaptionedImage {
  Image image;
  std::string caption;
};

struct StudyPage {
  const SceneStudy& study;
  std::string scene;                     ///< the scene's name
  std::string views;                     ///< "camera 0, camera 24, 1600 x 1200 pixels"
  std::string plots;                     ///< caption: "plush, 4 views, 1600 x 1200 pixels"
  std::vector<CaptionedImage> pictures;  ///< pictures of the first view
  std::vector<CaptionedImage> example;   ///< pictures of study.example; may be empty
  std::string made_with;                 ///< sentences about program, machine and time
};

/// The page as one HTML file. Plots are drawn with gnuplot. If that fails, the page says so and has
/// tables instead, and `problem` is set to one sentence; otherwise to "".
std::string format_study_page(const StudyPage& page, std::string& problem);

}  // namespace qs
