// SPDX-License-Identifier: MIT
//
// Composites one tile with the rules of kernel/blend.h, a cell of 4x4 pixels at a time: its pixels,
// in the order of the vector code, and parts of its list that are prepared for them.
#pragma once

#include <cstdint>

#include "raster/cpu/fast/pipeline.h"
#include "raster/kernel/constants.h"

namespace qs::cpu::fast {

struct TileJob {
  const std::uint32_t* list;  ///< slots front to back
  std::uint32_t length;
  const Record* records;  ///< per slot
  int x0, y0;             ///< the tile's first pixel
  int width, height;      ///< width and height of the part inside the image, in pixels
  glm::vec3 background;
  float least_transmittance;  ///< a pixel stops before it falls below this
  float* color;               ///< at the tile's first pixel; null = not requested
  std::uint32_t* evaluated;   ///< at the tile's first pixel; null = not requested
  std::size_t stride;         ///< pixels per row of the image
  /// Instead of colours, notes entries that a chosen pixel blends with a weight: 1 per list entry.
  std::uint8_t* seen = nullptr;
  const std::uint8_t* chosen = nullptr;  ///< with `seen`: of the tile's pixels, row by row
  float weight = 0;                      ///< with `seen`
  /// Red is the depth of a Gaussian and green is 1: blue becomes DepthMaps::median.
  bool depths = false;
};

/// Tiles consist of cells, because most Gaussians reach only a part of a tile.
constexpr int kCellSide = 4;
constexpr int kCellPixels = kCellSide * kCellSide;
constexpr int kCellsInRow = kTileSize / kCellSide;
constexpr int kCells = kCellsInRow * kCellsInRow;

/// Pixels composited together, row by row, stored as one array per value.
struct alignas(64) Cell {
  /// 0: the pixel has stopped or lies outside of the image. Otherwise >= the job's least.
  float transmittance[kCellPixels];
  /// The colours begin with the background, which the composited colours do not contain. So the
  /// transmittance is needed only to decide when a pixel stops.
  float red[kCellPixels], green[kCellPixels], blue[kCellPixels];
};

struct Tile {
  Cell cells[kCells];
  bool open[kCells];  ///< true if the cell may have live pixels
  alignas(64) std::uint32_t evaluated[kCells][kCellPixels];  ///< list entries up to the stop

  static int cell_of(int column, int row) {
    return row / kCellSide * kCellsInRow + column / kCellSide;
  }
  static int pixel_of(int column, int row) {
    return row % kCellSide * kCellSide + column % kCellSide;
  }

  explicit Tile(const TileJob& job);

  /// True if a cell is open.
  bool live() const;
  void write(const TileJob& job) const;
};

inline constexpr float kLog2Of256AlphaMax = 8 - 0.014499570f;

/// A part of a tile's list, prepared for compositing.
struct alignas(64) Batch {
  static constexpr std::uint32_t kEntries = 128;
  static constexpr std::uint32_t kVector = 16;   ///< most lanes of a vector: room for whole stores
  static constexpr std::uint32_t kMultiple = 4;  ///< a cell's entries are a multiple of it
  static constexpr std::uint32_t kNone = kEntries;  ///< an entry that has no alpha anywhere

  /// The part that depends on the column of pixels: log2 of 256 alpha is
  /// level - (scale Y - offset)^2 in the row Y below the tile's middle.
  struct alignas(64) Columns {
    float level[kTileSize], offset[kTileSize];
  };
  struct alignas(16) Factors {
    float scale;
    float red, green, blue;  ///< without the background
  };
  Columns columns[kEntries + 1];  ///< per entry
  Factors factors[kEntries + 1];  ///< per entry

  /// Per cell: the entries that may have a pixel with alpha >= 1/255 in it, front to back, and
  /// kNone up to a multiple of kMultiple.
  std::uint32_t reaching[kCells][kEntries + kVector];
  std::uint32_t counts[kCells];
  bool limited;               ///< true if an entry may have an alpha above kAlphaMax
  float least_transmittance;  ///< of the job
  float weight;               ///< of the job, above 0

  explicit Batch(const TileJob& job);

  /// Loads entries [first, first + size) of the list. Skips closed cells.
  void load(const TileJob& job, std::uint32_t first, std::uint32_t size, const bool* open);
};

/// In blend_tile.cpp.
void blend_tile(const TileJob& job);

}  // namespace qs::cpu::fast
