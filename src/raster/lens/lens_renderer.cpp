// SPDX-License-Identifier: MIT
#include "raster/lens/lens_renderer.h"

#include <algorithm>
#include <chrono>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "base/fail.h"
#include "raster/lens/lens_map.h"
#include "raster/scene/cubic_taps.h"

namespace qs {
namespace {

// The camera with its horizon level: it looks as far up or down as the lens, which is not at all,
// and in the direction of the camera, or of the camera's top if that looks straight up or down.
Camera leveled(Camera camera, const glm::dvec3& up) {
  const glm::dmat3 axes = glm::transpose(glm::dmat3(camera.view_from_world));
  const glm::dvec3 eye = camera.position();
  const auto flat = [&](const glm::dvec3& v) { return v - up * glm::dot(up, v); };
  constexpr double kFlat = 1e-3;
  glm::dvec3 forward = flat(axes[2]);
  if (glm::length(forward) < kFlat) forward = flat(-axes[1]) * -glm::sign(glm::dot(axes[2], up));
  forward = glm::normalize(forward);
  const glm::dmat3 turn = glm::transpose(glm::dmat3(glm::cross(forward, up), -up, forward));
  camera.view_from_world = glm::dmat4x3(turn[0], turn[1], turn[2], -(turn * eye));
  return camera;
}

Camera parallel(Camera camera, double height) {
  camera.projection = Projection::orthographic;
  camera.focal_px = glm::dvec2(camera.height / height);
  camera.center_px = 0.5 * glm::dvec2(camera.width - 1, camera.height - 1);
  return camera;
}

// The camera of an eye beside the lens's: -0.5 for the left one and 0.5 for the right one.
Camera eye_of_lens(Camera camera, double side, double eye_distance) {
  camera.view_from_world[3].x -= side * eye_distance;
  return camera;
}

void add(RenderStats& sum, const RenderStats& face) {
  sum.frame_ms += face.frame_ms;
  sum.cpu_ms += face.cpu_ms;
  sum.count_ms += face.count_ms;
  for (int stage = 0; stage < kStageCount; ++stage) sum.stage_ms[stage] += face.stage_ms[stage];
  sum.pipeline = face.pipeline;
  sum.gaussians = face.gaussians;
  sum.threads = face.threads;
  sum.visible += face.visible;
  sum.tile_pairs += face.tile_pairs;
  sum.listed += face.listed;
  sum.sort_bytes += face.sort_bytes;
  sum.max_pairs_in_a_tile = std::max(sum.max_pairs_in_a_tile, face.max_pairs_in_a_tile);
  if (face.used_pairs) sum.used_pairs = sum.used_pairs.value_or(0) + *face.used_pairs;
}

void add(std::vector<ModePairs>& sum, const std::vector<ModePairs>& face) {
  sum.resize(std::max(sum.size(), face.size()));
  for (std::size_t mode = 0; mode < face.size(); ++mode) {
    sum[mode].tile_pairs += face[mode].tile_pairs;
    sum[mode].visible += face[mode].visible;
  }
}

// The interpolated value of channel c at `at` is the sum of four columns of four rows.
template <int kChannels>
std::array<float, kChannels> interpolated(const float* values, int width, const FacePixel& at) {
  const CubicTaps across = cubic_taps(double{at.x}), down = cubic_taps(double{at.y});
  float columns[4 * kChannels] = {};
  for (int row = 0; row < 4; ++row) {
    const float* const from =
        values + (static_cast<std::ptrdiff_t>(down.first + row) * width + across.first) * kChannels;
    for (int k = 0; k < 4 * kChannels; ++k) columns[k] += down.weights[row] * from[k];
  }
  std::array<float, kChannels> result{};
  for (int column = 0; column < 4; ++column)
    for (int c = 0; c < kChannels; ++c)
      result[static_cast<std::size_t>(c)] +=
          across.weights[column] * columns[column * kChannels + c];
  return result;
}

using Clock = std::chrono::steady_clock;

class LensRenderer final : public Renderer {
 public:
  LensRenderer(std::unique_ptr<Renderer> inner, ThreadPool& pool)
      : inner_(std::move(inner)), pool_(pool) {}

  void upload(std::shared_ptr<const GaussianCloud> cloud, const Progress& progress) override {
    inner_->upload(std::move(cloud), progress);
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
    LensMap map;
  };

  // The view of parallel rays as `inner_` draws it.
  static CountedView without_lens(CountedView view) {
    const LensView& lens = *view.settings.lens;
    view.camera = parallel(placed(view.camera, lens), lens.height);
    view.settings.lens.reset();
    return view;
  }

  static Camera placed(const Camera& camera, const LensView& lens) {
    return lens.up ? leveled(camera, *lens.up) : camera;
  }

  // The map of the lens, of the last ones or made now.
  const LensMap& map_of(const std::shared_ptr<const LensView>& lens, glm::ivec2 size) {
    constexpr std::size_t kMost = 2;  // of the view at rest and of the moving one
    const auto is_it = [&](const Made& made) { return made.lens == lens && made.map.size == size; };
    auto found = std::ranges::find_if(made_, is_it);
    if (found == made_.end()) {
      if (made_.size() == kMost) made_.pop_back();
      made_.push_back({lens, make_lens_map(lens->sized(size), size, lens->faces, pool_)});
      found = made_.end() - 1;
    }
    std::rotate(made_.begin(), found, found + 1);
    return made_.front().map;
  }

  void prepare(const Camera& camera, const RenderSettings& settings, const Outputs& outputs) {
    const std::size_t pixels =
        static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height);
    result_ = {};
    result_.grid = TileGrid::of_image(camera.width, camera.height, settings.tile_px);
    if (outputs.color) result_.color = Image(camera.width, camera.height, 3);
    if (!outputs.depth) return;
    for (std::vector<float>* map :
         {&result_.depth.alpha, &result_.depth.expected, &result_.depth.median})
      map->assign(pixels, 0);
  }

  const Frame& through(const Camera& camera, const RenderSettings& settings, const Outputs& outputs,
                       const Target& target, const std::stop_token& stop) {
    if (outputs.pairs || outputs.evaluated || outputs.trace || outputs.region ||
        std::holds_alternative<GlTexture>(target))
      fail(ErrorKind::device,
           "lens {}: its faces are separate pictures: there is no map of tiles or pairs, no trace, "
           "no region and no texture of the whole",
           settings.lens->text);
    prepare(camera, settings, outputs);
    Outputs of_face = outputs;
    if (outputs.counted) of_face.mode_pairs = false;
    draw({camera, settings}, of_face, stop);
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
      draw_eye(eye_of_lens(camera, eye - 0.5, lens.eye_distance), eye, 2, view.settings, outputs,
               stop);
  }

  // Draws the faces into the rows of eye number `eye` of `eyes`.
  void draw_eye(const Camera& camera, int eye, int eyes, const RenderSettings& settings,
                const Outputs& outputs, const std::stop_token& stop) {
    const int height = camera.height / eyes;
    const LensMap& map = map_of(settings.lens, {camera.width, height});
    RenderSettings plain = settings;
    plain.lens.reset();
    plain.dilation *= kFaceScale * kFaceScale;
    const std::size_t offset = static_cast<std::size_t>(eye) * map.nearest.size();
    if (outputs.color) fill_unseen(map, offset, settings.background);
    const auto parts = static_cast<float>(eyes) * static_cast<float>(map.faces.size());
    for (std::size_t i = 0; i < map.faces.size(); ++i) {
      const float done =
          static_cast<float>(eye) / static_cast<float>(eyes) + static_cast<float>(i) / parts;
      if (report_)
        inner_->report_frames_to([=, this](float fraction) { report_(done + fraction / parts); });
      const FaceMap& face = map.faces[i];
      const Frame& frame = inner_->render(face.placed(camera), plain, outputs, HostImage{}, stop);
      add(result_.mode_pairs, frame.mode_pairs);
      const Clock::time_point begin = Clock::now();
      const double processor_seconds = pool_.processor_seconds();
      combine(frame, face, map.nearest, static_cast<std::uint8_t>(i), offset, outputs);
      RenderStats stats = frame.stats;
      const float ms = std::chrono::duration<float, std::milli>(Clock::now() - begin).count();
      stats.frame_ms += ms;
      if (stats.threads > 0)
        stats.cpu_ms += static_cast<float>(1e3 * (pool_.processor_seconds() - processor_seconds));
      stats.stage_ms[static_cast<int>(Stage::blend)] += ms;
      add(result_.stats, stats);
    }
    if (report_) inner_->report_frames_to(report_);
  }

  void fill_unseen(const LensMap& map, std::size_t offset, const glm::vec3& background) {
    pool_.for_each(map.nearest.size(), 1 << 16, [&](std::size_t at) {
      if (map.nearest[at] != LensMap::kNoFace) return;
      for (int c = 0; c < 3; ++c)
        result_.color.values[3 * (offset + at) + static_cast<std::size_t>(c)] = background[c];
    });
  }

  // Adds a face to the picture.
  void combine(const Frame& frame, const FaceMap& face, const std::vector<std::uint8_t>& nearest,
               std::uint8_t number, std::size_t offset, const Outputs& outputs) {
    const int width = face.camera.width;
    const DepthMaps& from = frame.depth;
    pool_.for_each(face.pixels.size(), 1 << 14, [&](std::size_t k) {
      const FacePixel& pixel = face.pixels[k];
      const std::size_t at = offset + pixel.pixel;
      if (outputs.color) {
        const auto color = interpolated<3>(frame.color.values.data(), width, pixel);
        for (std::size_t c = 0; c < 3; ++c)
          result_.color.values[3 * at + c] += pixel.weight * color[c];
      }
      if (!outputs.depth) return;
      const float alpha = interpolated<1>(from.alpha.data(), width, pixel)[0];
      result_.depth.alpha[at] += pixel.weight * std::clamp(alpha, 0.0f, 1.0f);
      if (nearest[pixel.pixel] != number) return;
      const auto source =
          static_cast<std::size_t>(std::lround(pixel.y)) * static_cast<std::size_t>(width) +
          static_cast<std::size_t>(std::lround(pixel.x));
      result_.depth.expected[at] = from.expected[source];
      result_.depth.median[at] = from.median[source];
    });
  }

  std::unique_ptr<Renderer> inner_;
  ThreadPool& pool_;
  std::function<void(float fraction)> report_;
  std::vector<Made> made_;  // the last used first
  Frame result_;
};

}  // namespace

std::unique_ptr<Renderer> with_lenses(std::unique_ptr<Renderer> inner, ThreadPool& pool) {
  return std::make_unique<LensRenderer>(std::move(inner), pool);
}

}  // namespace qs
