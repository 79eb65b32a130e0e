// SPDX-License-Identifier: MIT
#include "io/camera/photographs.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "base/fail.h"
#include "io/picture/image_file.h"
#include "raster/scene/cubic_taps.h"
#include "raster/scene/image_metrics.h"

namespace qs {
namespace {

Image as_rgb(const Image& image, glm::vec3 background) {
  const bool gray = image.channels < 3, transparent = image.channels % 2 == 0;
  Image rgb(image.width, image.height, 3);
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const float alpha = transparent ? image.at(x, y, image.channels - 1) : 1.0f;
      for (int c = 0; c < 3; ++c)
        rgb.at(x, y, c) = image.at(x, y, gray ? 0 : c) * alpha + background[c] * (1 - alpha);
    }
  }
  return rgb;
}

// Calls visit(x, y) for every pixel, from several threads.
template <class Visit>
void for_each_pixel(int width, int height, ThreadPool& pool, const Visit& visit) {
  pool.for_chunks(static_cast<std::size_t>(height), 16,
                  [&](std::size_t begin, std::size_t end, int) {
                    for (int y = static_cast<int>(begin); y < static_cast<int>(end); ++y)
                      for (int x = 0; x < width; ++x) visit(x, y);
                  });
}

// The pixels around a position along one axis, and their weights: two pixels, or four by
// Catmull-Rom.
struct Taps {
  int first, count;
  float weights[4];
};

Taps taps_at(double position, bool is_cubic) {
  if (is_cubic) {
    const auto [first, w] = cubic_taps(position);
    return {first, 4, {w[0], w[1], w[2], w[3]}};
  }
  const int pixel = static_cast<int>(std::floor(position));
  const auto t = static_cast<float>(position - pixel);
  return {pixel, 2, {1 - t, t}};
}

// A photograph between its pixels.
struct Sampler {
  const Image& photograph;
  bool is_cubic, is_panorama;

  const float* pixel(int x, int y) const {
    const int width = photograph.width, height = photograph.height;
    if (is_panorama) {  // the other side of a pole is half a turn away
      const int row = y < 0 ? -1 - y : y < height ? y : 2 * height - 1 - y;
      x = (x + width + (row == y ? 0 : width / 2)) % width;
      y = row;
    }
    return photograph.row(std::clamp(y, 0, height - 1)) +
           std::clamp(x, 0, width - 1) * photograph.channels;
  }

  // Adds the values of all channels.
  void add(glm::dvec2 at, float* values) const {
    if (!is_panorama)
      at = glm::clamp(at, glm::dvec2(0.0), glm::dvec2(photograph.width - 1, photograph.height - 1));
    const Taps across = taps_at(at.x, is_cubic), down = taps_at(at.y, is_cubic);
    std::array<const float*, 16> pixels;
    for (int i = 0; i < across.count * down.count; ++i)
      pixels[static_cast<std::size_t>(i)] =
          pixel(across.first + i % across.count, down.first + i / across.count);
    for (int c = 0; c < photograph.channels; ++c) {
      float sum = 0;
      const float* const* next = pixels.data();
      for (int j = 0; j < down.count; ++j) {
        float row = 0;
        for (int i = 0; i < across.count; ++i) row += across.weights[i] * (*next++)[c];
        sum += down.weights[j] * row;
      }
      values[c] += sum;
    }
  }
};

// Samples of a face's pixel along its axes, one per pixel of the photograph that it covers there,
// up to 16, as next to the poles of a panorama.
glm::ivec2 samples_of(const LensCamera& view, glm::dvec2 pixel) {
  if (!view.is_face()) return {1, 1};
  const auto along = [&](glm::dvec2 half) {
    const auto low = view.source_of(pixel - half), high = view.source_of(pixel + half);
    if (!low || !high) return 1;
    glm::dvec2 covered = *high - *low;
    covered.x = std::remainder(covered.x, view.lens->size_px.x);  // a panorama goes around
    return static_cast<int>(std::lround(std::clamp(glm::length(covered), 1.0, 16.0)));
  };
  return {along({0.5, 0}), along({0, 0.5})};
}

}  // namespace

Image read_as_taken(const std::filesystem::path& path, glm::vec3 background,
                    const LensCamera& taken) {
  Image photograph = as_rgb(read_image(path), background);
  if (taken.camera.width > 0) require_same_shape(photograph, path, taken.photograph_size());
  return photograph;
}

Image read_photograph(const std::filesystem::path& path, glm::vec3 background, int divisor,
                      ThreadPool& pool, const LensCamera& taken) {
  return divided(undistorted(read_as_taken(path, background, taken), taken, pool), divisor, pool);
}

Image divided(const Image& photograph, int divisor, ThreadPool& pool) {
  const auto side = [&](int pixels) { return std::max(1, (pixels + divisor / 2) / divisor); };
  return area_average(photograph, side(photograph.width), side(photograph.height), pool);
}

void require_same_shape(const Image& photograph, const std::filesystem::path& path,
                        glm::dvec2 camera_size) {
  const double scale = photograph.width / camera_size.x;
  if (std::abs(scale * camera_size.y - photograph.height) <= 1 + scale) return;
  const double turned_scale = photograph.height / camera_size.x;
  const bool is_turned =
      std::abs(turned_scale * camera_size.y - photograph.width) <= 1 + turned_scale;
  if (const int orientation = exif_orientation(path); orientation > 1 && is_turned)
    fail(
        "{}: {} x {} pixels, but its camera has {} x {}: its EXIF tag Orientation is {}, and the "
        "camera is of the turned picture; turn the pixels of the photographs first (mogrify "
        "-auto-orient)",
        path.string(), photograph.width, photograph.height, camera_size.x, camera_size.y,
        orientation);
  fail("{}: {} x {} pixels do not have the aspect ratio of its camera, {} x {}", path.string(),
       photograph.width, photograph.height, camera_size.x, camera_size.y);
}

Image undistorted(const Image& photograph, const LensCamera& camera, ThreadPool& pool) {
  if (!camera.lens) return photograph;
  const glm::dvec2 factor = glm::dvec2(photograph.width, photograph.height) / camera.lens->size_px;
  const auto scaled_side = [](int side, double by) {
    return std::max(1, static_cast<int>(std::lround(side * by)));
  };
  LensCamera view = camera.scaled(scaled_side(camera.camera.width, factor.x),
                                  scaled_side(camera.camera.height, factor.y));
  view.lens = camera.lens->scaled(factor);
  Image result(view.camera.width, view.camera.height, photograph.channels);
  const Sampler sampler{photograph, view.is_face(), view.lens->model->plane == LensPlane::panorama};
  for_each_pixel(result.width, result.height, pool, [&](int x, int y) {
    const glm::dvec2 pixel(x, y);
    const glm::ivec2 samples = samples_of(view, pixel);
    float* const values = &result.at(x, y, 0);
    int count = 0;
    for (int i = 0; i < samples.x * samples.y; ++i) {
      const glm::dvec2 cell(i % samples.x, i / samples.x);
      const auto source = view.source_of(pixel + (cell + 0.5) / glm::dvec2(samples) - 0.5);
      if (!source) continue;
      sampler.add(*source, values);
      ++count;
    }
    if (count > 1)
      for (int c = 0; c < result.channels; ++c) values[c] /= static_cast<float>(count);
  });
  return result;
}

std::vector<std::uint8_t> lens_mask(const LensCamera& camera, int width, int height,
                                    ThreadPool& pool) {
  if (!camera.lens) return {};
  const LensCamera view = camera.scaled(width, height);
  std::vector<std::uint8_t> mask(static_cast<std::size_t>(width) *
                                 static_cast<std::size_t>(height));
  // Corners at 0.5 would leave out pixels at edges that rounding moved.
  constexpr double kCorner = 0.45;
  for_each_pixel(width, height, pool, [&](int x, int y) {
    bool is_shown = true;
    for (const glm::dvec2 at : {glm::dvec2(0), {-1, -1}, {1, -1}, {-1, 1}, {1, 1}})
      is_shown = is_shown && view.source_of(glm::dvec2(x, y) + kCorner * at);
    mask[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
         static_cast<std::size_t>(x)] = is_shown ? 1 : 0;
  });
  if (std::ranges::count(mask, std::uint8_t{0}) == 0) return {};
  return mask;
}

}  // namespace qs
