// SPDX-License-Identifier: MIT
//
// Pipeline `fast` of the CPU backend: the results of `classic` with vector code on all threads.
// Blocks that the view can show pass through the steps of survivors.h, and then the stages follow.
// Buffers are reused from frame to frame.
#pragma once

#include <memory>

#include "raster/cpu/common/tile_lists.h"
#include "raster/cpu/fast/survivors.h"
#include "raster/kernel/blend.h"
#include "raster/kernel/cull/mode.h"
#include "raster/kernel/tile_grid.h"

namespace qs::cpu::fast {

// The tiles that the culling mode assigns to each Gaussian, as rectangles that do not overlap.
// Rectangles are short lists even for Gaussians with many tiles, and have the same form for walks
// along rows and along columns. They are computed once per frame; counting and binning read them.

/// Rows and columns [begin, end) of tiles. Sides of images are below 2^20 pixels.
struct PackedTileRect {
  std::uint16_t row_begin, row_end, column_begin, column_end;
};

/// The rectangles of a chunk's visible Gaussians, one Gaussian after the other. add() is inlined,
/// because calls of std::vector::push_back() were slow here.
class RectList {
 public:
  std::size_t size() const { return size_; }
  const PackedTileRect& operator[](std::size_t i) const { return rects_[i]; }

  void clear() { size_ = 0; }
  void add(PackedTileRect rect) {
    if (size_ == rects_.size()) [[unlikely]]
      grow();
    rects_[size_++] = rect;
  }

 private:
  void grow() { rects_.resize(2 * size_ + 2048); }

  Array<PackedTileRect> rects_;  ///< its size is the capacity
  std::size_t size_ = 0;
};

/// The rectangles of one Gaussian: one, or several in its chunk's RectList. Bin reads listings in
/// random order, so they are small.
union Listing {
  struct Several {
    std::uint16_t mark;   ///< kSeveral, which is no first row
    std::uint16_t count;  ///< > 1
    std::uint32_t first;
  };
  static constexpr std::uint16_t kSeveral = 65535;

  PackedTileRect rect;
  Several several;

  bool single() const { return rect.row_begin != kSeveral; }
};

/// Appends the rectangles of `survivors` to `rects`, removes survivors without any, and writes
/// listings[k] and rows[k] for the k-th survivor that remains. `rows`: see FastVisible.
void list_tiles(CullMode mode, TileGrid grid, Survivors& survivors, RectList& rects,
                Listing* listings, std::uint32_t* rows);

/// A visible Gaussian as the blend stage reads it: one cache line. At the offset (dx, dy) from the
/// mean, log2 of 256 alpha is log2_256_opacity - along dx^2 - (scale (dy - slope dx))^2: rounding
/// cannot lift it above log2_256_opacity.
struct alignas(64) Record {
  float mean_x, mean_y;
  float log2_256_opacity;
  float along, slope;
  float height;  ///< px: at least 1 / scale
  float scale;   ///< 1 / px
  float red, green, blue;

  float opacity() const { return exp2_polynomial(log2_256_opacity - 8); }
};

struct FastVisible : VisibleSlots {
  Array<std::uint32_t> rows;    ///< per slot: tile rows of the listing, begin + (end << 16)
  Array<Listing> listings;      ///< per slot
  Array<Record> records;        ///< per slot
  std::vector<RectList> rects;  ///< per chunk

  /// Pairs per tile as corner differences of rectangles, (rows + 1) x (columns + 1): summing along
  /// both axes gives the counts. One table per thread.
  std::vector<Array<std::int32_t>> corners;

  /// The first rectangle of a slot that has several.
  const PackedTileRect* rects_of(std::uint32_t slot) const {
    return &rects[slot / kChunk][listings[slot].several.first];
  }
};

/// Stage 1: finds the Gaussians that the view shows, and their tiles. `scene` was made of
/// frame.cloud. Footprints are filled if `traced`.
void preprocess(const FrameContext& frame, const SceneBlocks& scene, bool traced,
                FastVisible& visible);

/// A band of tile rows for one thread. It has its own list of Gaussians, sorted front to back, so
/// that threads do not wait for each other. A Gaussian on the border of two bands is in both.
struct Band {
  int top = 0, bottom = 0;  ///< tile rows [top, bottom)
  SortItems items;          ///< keys: bits of the depths, values: slots
  ThreadPool alone{1};      ///< scratch: runs the band's loops on the thread that calls it

  const Array<std::uint32_t>& slots() const { return items.values; }
};

using Bands = std::vector<std::unique_ptr<Band>>;

/// Stage 2: divides the tile rows into a band per thread, with about the same number of pairs, and
/// sorts their Gaussians by ascending (bits of the depth, index in the cloud).
void sort(const FrameContext& frame, const FastVisible& visible, Bands& bands);

/// Stage 3: lists every visible Gaussian in its tiles, in one pass front to back. Throws
/// Error(device) if the lists do not fit into memory.
void bin(const FrameContext& frame, const FastVisible& visible, const Bands& bands,
         TileLists& lists);

/// The order in which tiles are composited.
struct TileQueue {
  Array<std::uint32_t> tiles;
};

/// Stage 4: composites every tile's list front to back. Fills color and evaluated of `result` if
/// requested. They already have their sizes. `depths`: see TileJob.
void blend(const FrameContext& frame, const FastVisible& visible, const TileLists& lists,
           TileQueue& queue, const Outputs& outputs, Frame& result, bool depths = false);

/// Outputs::seen: adds the Gaussians of the lists to Frame::seen, which is empty.
void mark_seen(const FrameContext& frame, const FastVisible& visible, const TileLists& lists,
               const SeenPixels& pixels, GaussianSet& seen);

class FastPipeline {
 public:
  void upload(SceneBlocks scene) { scene_ = std::move(scene); }
  void exchange(SceneBlocks& scene) { std::swap(scene_, scene); }
  bool update(const GaussianCloud& cloud, std::span<const std::uint32_t> changed,
              ThreadPool& pool) {
    return scene_.update(cloud, changed, pool);
  }
  void set_drawn(const GaussianSet& set, ThreadPool& pool) { scene_.set_drawn(set, pool); }

  /// Fills `result`, whose maps already have their sizes, except for the frame's time. The uploaded
  /// scene was made of frame.cloud.
  void draw(const FrameContext& frame, const Outputs& outputs, Frame& result);

  /// Fills Frame::depth, Frame::seen and Frame::share of a frame that draw() has drawn, or another
  /// pipeline.
  void pass_again(const FrameContext& frame, bool is_drawn, const Outputs& outputs, Frame& result);

  /// Adds the counts of every mode for a view to `sums`; needs no frame of it.
  void count_modes(const FrameContext& counted, ModeSums& sums) const;

 private:
  void list(const FrameContext& frame, bool traced, RenderStats& stats);
  template <class ColorOf>
  Image painted(const FrameContext& view, bool depths, const ColorOf& color_of);

  SceneBlocks scene_;
  FastVisible visible_;
  Bands bands_;
  TileLists lists_;
  TileQueue queue_;
};

}  // namespace qs::cpu::fast
