// SPDX-License-Identifier: MIT
//
// A renderer that draws the cut of each view of a tree whose pages are streamed.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "app/session/session.h"
#include "raster/pages/page_stream.h"

namespace qs {

/// Facts of a cut.
struct LevelFacts {
  Camera camera = {};       ///< of the view
  std::size_t drawn = 0;    ///< nodes
  std::size_t missing = 0;  ///< pages that the cut lacks
  float limit = 0;          ///< LodCut::limit
  double ms = 0;            ///< of making it, with waiting for pages
  StreamFacts stream;
  bool is_new = false;                      ///< it differs from the cut before: draw it
  std::vector<std::string> sentences = {};  ///< PageStream::take_sentences()
  std::size_t selected = 0;                 ///< nodes that edits select, in windows

  /// "24,000 of 1,720,559 nodes, limit 0.012, 27 pages read (3.4 MB), 0 missing, 230 ms"
  std::string text() const;
};

using LevelReport = std::function<void(const LevelFacts&)>;

/// Draws streamed trees, and other scenes as `inner` does. A new cut is uploaded to `inner`; the
/// times of frames do not include that. In the place of any Outputs::share, windows draw the share
/// of the nodes that edits select. Without `report` every view has its own cut, with all pages
/// that it needs, and a line on stderr; `pool` makes it. With `report`, for a window, the last cut
/// that is ready is drawn, while a thread makes the next one of the pages in memory and calls
/// `report`. A cut that hardly differs from the shown one is drawn once the camera rests. While
/// *awaits is true, frames are as without `report`: for films and measurements.
std::unique_ptr<Renderer> with_levels(std::unique_ptr<Renderer> inner, const LevelOptions& options,
                                      ThreadPool& pool, LevelReport report = {},
                                      const std::atomic<bool>* awaits = nullptr);

/// As read_scene(); instances of a tree are a tree too.
Scene open_scene(const std::filesystem::path& path, ThreadPool& pool, const ReadOptions& options);

/// The tree of the scene that is uploaded next; null for scenes without. Other renderers than those
/// of with_levels() ignore it.
void expect_stream(Renderer& renderer, const std::shared_ptr<PageStream>& stream);

/// A frame whose indices are of this cloud.
struct DrawnView {
  const Frame& frame;
  std::shared_ptr<const GaussianCloud> cloud;
  /// Of a tree: the numbers of leaves in the sources of its file, else kNoNumber.
  std::vector<std::uint32_t> numbers = {};
};

/// Draws a view of the session's scene as the settings' defaults have it; of a tree the cut with
/// all its pages.
DrawnView draw_view(const Session& session, const Camera& camera, const Outputs& outputs,
                    std::stop_token stop);

}  // namespace qs
