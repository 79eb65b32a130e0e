// SPDX-License-Identifier: MIT
//
// cull_grades SCENE CAMERAS INDEX: the tiles that every culling mode lists in a view, compared with
// the tiles that have a pixel with alpha >= 1/255, found by trying every pixel. A pair without such
// a pixel is a false positive (also if the pixel would have stopped before); a tile that has such a
// pixel and is not listed is a loss. It makes the tables of docs/peers.md.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "io/camera/cameras.h"
#include "raster/api/renderer.h"
#include "raster/kernel/blend.h"
#include "support/pool.h"
#include "support/scene_files.h"

namespace qs {
namespace {

class Grades {
 public:
  Grades(const char* scene, const char* cameras, int index)
      : camera_(read_cameras(cameras).at(static_cast<std::size_t>(index))),
        renderer_(make_renderer(Backend::cpu, test::pool(0))) {
    renderer_->upload(test::read_scene(scene).cloud, {});
    find_needed(trace_of(find_culler("adr")));
  }

  void print() {
    std::printf("%-14s%12s%16s%9s%9s\n", "mode", "pairs", "false positives", "share", "losses");
    for (CullMode mode = 1; mode <= mode_count(); ++mode) {
      const Trace& trace = trace_of(mode);
      std::uint64_t hits = 0;
      for (std::size_t tile = 0; tile + 1 < trace.tile_begin.size(); ++tile) {
        for (std::uint64_t i = trace.tile_begin[tile]; i < trace.tile_begin[tile + 1]; ++i)
          hits += needed_.contains(key(trace.listed[i], tile));
      }
      const std::uint64_t pairs = trace.listed.size(), unused = pairs - hits;
      std::printf("%-14s%12lu%16lu%8.1f%%%9lu\n", mode_name(mode), pairs, unused,
                  100.0 * static_cast<double>(unused) / static_cast<double>(pairs),
                  needed_.size() - hits);
    }
  }

 private:
  static std::uint64_t key(std::uint32_t gaussian, std::size_t tile) {
    return std::uint64_t{gaussian} << 32 | tile;
  }

  const Trace& trace_of(CullMode mode) {
    RenderSettings settings;
    settings.mode = mode;
    Outputs outputs;
    outputs.color = false;
    outputs.trace = true;
    return renderer_->render(camera_, settings, outputs).trace;
  }

  /// `trace` is of mode adr, which loses nothing (tests/raster/kernel/culler_test.cpp).
  void find_needed(const Trace& trace) {
    std::unordered_map<std::uint32_t, std::size_t> slots;
    for (std::size_t slot = 0; slot < trace.gaussians.size(); ++slot)
      slots[trace.gaussians[slot]] = slot;
    const int columns = TileGrid::of_image(camera_.width, camera_.height).columns;
    for (std::size_t tile = 0; tile + 1 < trace.tile_begin.size(); ++tile) {
      const int x0 = static_cast<int>(tile) % columns * kTileSize;
      const int y0 = static_cast<int>(tile) / columns * kTileSize;
      for (std::uint64_t i = trace.tile_begin[tile]; i < trace.tile_begin[tile + 1]; ++i) {
        if (has_visible_pixel(trace.splats[slots.at(trace.listed[i])], x0, y0))
          needed_.insert(key(trace.listed[i], tile));
      }
    }
  }

  bool has_visible_pixel(const Splat& splat, int x0, int y0) const {
    for (int y = y0; y < std::min(y0 + kTileSize, camera_.height); ++y) {
      for (int x = x0; x < std::min(x0 + kTileSize, camera_.width); ++x) {
        const float power = log2_falloff(splat, static_cast<float>(x) - splat.mean_px.x,
                                         static_cast<float>(y) - splat.mean_px.y);
        if (power <= 0 && alpha_of(splat, power) >= kAlphaMin) return true;
      }
    }
    return false;
  }

  Camera camera_;
  std::unique_ptr<Renderer> renderer_;
  std::unordered_set<std::uint64_t> needed_;
};

}  // namespace
}  // namespace qs

int main(int count, char** words) {
  if (count != 4) {
    std::fprintf(stderr, "usage: cull_grades SCENE CAMERAS INDEX\n");
    return 1;
  }
  qs::Grades(words[1], words[2], std::atoi(words[3])).print();
}
