// SPDX-License-Identifier: MIT
//
// The renderer of lens_renderer.h for the memory in which `inner` draws: Sums adds the faces of a
// picture up there.
//   Target face_target() const: where the faces are drawn
//   void begin(glm::ivec2 size, const Outputs& outputs): begins a picture of zeros with these maps
//   void begin_eye(std::shared_ptr<const LensMap> map, std::size_t first_pixel,
//                  const glm::vec3& background): begins the picture of an eye. Pixels that its lens
//                  does not show get the background
//   void add(const Frame& face, std::size_t number): adds face `number` of the map; reads it at
//                  once, or in DeviceMaps::stream
//   void wait(): until all faces are added
//   void finish(const Target& target, Frame& result): moves the picture to its target
#pragma once

#include <algorithm>
#include <chrono>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "raster/api/renderer.h"
#include "raster/lens/lens_map.h"
#include "raster/lens/lens_view.h"

namespace qs {
namespace lens {
/// The camera with its horizon level: it looks as far up or down as the lens, which is not at all,
/// and in the direction of the camera, or of the camera's top if that looks straight up or down.
Camera leveled(Camera camera, const glm::dvec3& up);

/// The camera of a picture of parallel rays, `height` world units high.
Camera parallel(Camera camera, double height);

/// The camera of an eye beside the lens's: -0.5 for the left one and 0.5 for the right one.
Camera eye_of_lens(Camera camera, double side, double eye_distance);

inline float ms_since(std::chrono::steady_clock::time_point begin) {
  return std::chrono::duration<float, std::milli>(std::chrono::steady_clock::now() - begin).count();
}

/// Adds all but frame_ms: faces may be drawn at the same time.
void add(RenderStats& sum, const RenderStats& face);
void add(std::vector<ModePairs>& sum, const std::vector<ModePairs>& face);

/// The maps of tiles and pixels of a picture of faces. A tile's pairs in a face are divided among
/// the tiles of the picture as the pixels that show it are; tiles that no pixel shows are in no
/// map. A pixel has the evaluated pairs of the nearest pixel of a face.
class CountMaps {
 public:
  CountMaps(const TileGrid& grid, glm::ivec2 size, const Outputs& outputs);

  /// Adds face `number` of the map, whose picture begins at a pixel of the whole picture.
  void add(const LensMap& map, std::size_t number, const Frame& face, std::size_t first_pixel);
  void finish(Frame& result) const;

 private:
  TileGrid grid_;
  int width_;
  std::vector<double> pairs_, used_;  // per tile; empty: not requested
  std::vector<std::uint32_t> evaluated_;
};

/// Throws Error(device) for outputs and targets that pictures of faces do not have.
void check_outputs(const LensView& lens, const Outputs& outputs, const Target& target);

}  // namespace lens

template <class Sums>
class LensRenderer final : public Renderer {
 public:
  template <class OfSums>
  LensRenderer(std::unique_ptr<Renderer> inner, ThreadPool& pool, OfSums& of_sums)
      : inner_(std::move(inner)), pool_(pool), sums_(of_sums) {}

  void upload(std::shared_ptr<const GaussianCloud> cloud, const Progress& progress) override {
    inner_->upload(std::move(cloud), progress);
  }

  std::function<void()> prepare_upload(std::shared_ptr<const GaussianCloud> cloud,
                                       ThreadPool& pool) override {
    return inner_->prepare_upload(std::move(cloud), pool);
  }

  void set_drawn(GaussianSet drawn) override { inner_->set_drawn(std::move(drawn)); }

  void update(std::span<const std::uint32_t> changed) override { inner_->update(changed); }

  void prepare_target(const Target& target) override { inner_->prepare_target(target); }

  void report_frames_to(std::function<void(float fraction)> report) override {
    report_ = std::move(report);
    inner_->report_frames_to(report_);
  }

  const Frame& render(const Camera& camera, const RenderSettings& settings, const Outputs& outputs,
                      const Target& target, std::stop_token stop) override {
    if (!settings.lens) return inner_->render(camera, settings, outputs, target, std::move(stop));
    if (!settings.lens->is_parallel()) return through(camera, settings, outputs, target, stop);
    const CountedView view = without_lens({camera, settings});
    Outputs of_view = outputs;
    if (outputs.counted) of_view.counted = without_lens(*outputs.counted);
    return inner_->render(view.camera, view.settings, of_view, target, std::move(stop));
  }

 private:
  // A map that was made, for the lens and the size of one eye's picture.
  struct Made {
    std::shared_ptr<const LensView> lens;
    std::shared_ptr<const LensMap> map;
  };

  // The view of parallel rays as `inner_` draws it.
  static CountedView without_lens(CountedView view) {
    const LensView& lens = *view.settings.lens;
    view.camera = lens::parallel(placed(view.camera, lens), lens.height);
    view.settings.lens.reset();
    return view;
  }

  static Camera placed(const Camera& camera, const LensView& lens) {
    return lens.up ? lens::leveled(camera, *lens.up) : camera;
  }

  // The map of the lens, of the last ones or made now.
  std::shared_ptr<const LensMap> map_of(const std::shared_ptr<const LensView>& lens,
                                        glm::ivec2 size) {
    const auto is_it = [&](const Made& made) {
      return made.lens->text == lens->text && made.lens->faces == lens->faces &&
             made.map->size == size;
    };
    auto found = std::ranges::find_if(made_, is_it);
    if (found == made_.end()) {
      if (made_.size() == kMostMaps) made_.pop_back();
      made_.push_back({lens, std::make_shared<const LensMap>(
                                 make_lens_map(lens->sized(size), size, lens->faces, pool_))});
      found = made_.end() - 1;
    }
    std::rotate(made_.begin(), found, found + 1);
    return made_.front().map;
  }

  const Frame& through(const Camera& camera, const RenderSettings& settings, const Outputs& outputs,
                       const Target& target, const std::stop_token& stop) {
    lens::check_outputs(*settings.lens, outputs, target);
    result_ = {};
    result_.grid = TileGrid::of_image(camera.width, camera.height, settings.tile_px);
    sums_.begin({camera.width, camera.height}, outputs);
    counts_.emplace(result_.grid, glm::ivec2(camera.width, camera.height), outputs);
    Outputs of_face = outputs;
    if (outputs.counted) of_face.mode_pairs = false;
    draw({camera, settings}, of_face, stop);
    sums_.finish(target, result_);
    counts_->finish(result_);
    if (outputs.counted && outputs.mode_pairs) {
      const RenderStats stats = result_.stats;
      draw(*outputs.counted, {.color = false, .mode_pairs = true}, stop);
      result_.stats = stats;
    }
    return result_;
  }

  void draw(const CountedView& view, const Outputs& outputs, const std::stop_token& stop) {
    const LensView& lens = *view.settings.lens;
    const Camera camera = placed(view.camera, lens);
    if (lens.eye_distance <= 0) return draw_eye(camera, 0, 1, view.settings, outputs, stop);
    for (int eye = 0; eye < 2; ++eye)
      draw_eye(lens::eye_of_lens(camera, eye - 0.5, lens.eye_distance), eye, 2, view.settings,
               outputs, stop);
  }

  // Draws the faces into the rows of eye number `eye` of `eyes`.
  void draw_eye(const Camera& camera, int eye, int eyes, const RenderSettings& settings,
                const Outputs& outputs, const std::stop_token& stop) {
    const int height = camera.height / eyes;
    const auto shared_map = map_of(settings.lens, {camera.width, height});
    const LensMap& map = *shared_map;
    RenderSettings plain = settings;
    plain.lens.reset();
    plain.dilation *= map.middle_pixel_area;
    const bool is_seen = outputs.color || outputs.depth;
    const std::size_t first_pixel = static_cast<std::size_t>(eye) * map.nearest.size();
    if (is_seen) sums_.begin_eye(shared_map, first_pixel, settings.background);
    std::vector<Camera> faces;
    for (const FaceMap& face : map.faces) faces.push_back(face.placed(camera));
    const auto parts = static_cast<float>(eyes) * static_cast<float>(faces.size());
    const auto report_face = [&](std::size_t i) {
      const float done =
          static_cast<float>(eye) / static_cast<float>(eyes) + static_cast<float>(i) / parts;
      if (report_)
        inner_->report_frames_to([=, this](float fraction) { report_(done + fraction / parts); });
    };
    report_face(0);
    const auto begin = std::chrono::steady_clock::now();
    const float count_ms = result_.stats.count_ms;
    inner_->render_each(
        faces, plain, outputs, sums_.face_target(), stop, [&](const Frame& frame, std::size_t i) {
          lens::add(result_.mode_pairs, frame.mode_pairs);
          const auto drawn = std::chrono::steady_clock::now();
          const double processor_seconds = pool_.processor_seconds();
          if (is_seen) sums_.add(frame, i);
          counts_->add(map, i, frame, first_pixel);
          RenderStats stats = frame.stats;
          if (stats.threads > 0)
            stats.cpu_ms +=
                static_cast<float>(1e3 * (pool_.processor_seconds() - processor_seconds));
          if (outputs.stage_times) {
            sums_.wait();
            stats.stage_ms[static_cast<int>(Stage::blend)] += lens::ms_since(drawn);
          }
          lens::add(result_.stats, stats);
          report_face(i + 1);
        });
    sums_.wait();
    result_.stats.frame_ms += lens::ms_since(begin) - (result_.stats.count_ms - count_ms);
    if (report_) inner_->report_frames_to(report_);
  }

  std::unique_ptr<Renderer> inner_;
  ThreadPool& pool_;
  Sums sums_;
  std::optional<lens::CountMaps> counts_;  // of the picture that is drawn
  std::function<void(float fraction)> report_;
  std::vector<Made> made_;  // the last used first
  Frame result_;
};

}  // namespace qs
