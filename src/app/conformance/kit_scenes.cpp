// SPDX-License-Identifier: MIT
#include "app/conformance/kit_scenes.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <glm/mat3x3.hpp>
#include <glm/trigonometric.hpp>

#include "raster/kernel/random.h"

namespace qs {
namespace {

constexpr int kKitWidth = 64, kKitHeight = 48;
constexpr double kKitFocal = 60;  ///< px

/// One Gaussian in convenient units.
struct Blob {
  glm::vec3 position{0, 0, 3};
  glm::vec3 sigma{0.2f};  ///< standard deviations, world units
  glm::vec3 color{1};     ///< colour without view dependence; may exceed 0..1
  float opacity = 0.9f;
  glm::quat rotation{1, 0, 0, 0};
};

/// The coefficients of Gaussian `i`.
glm::vec3* sh_of(GaussianCloud& cloud, std::size_t i) {
  return cloud.sh.data() + i * static_cast<std::size_t>(sh_coefficient_count(cloud.sh_degree));
}

/// A cloud with SH of degree `degree`; coefficients above the first are 0.
GaussianCloud cloud_of(const std::vector<Blob>& blobs, int degree = 0) {
  GaussianCloud cloud;
  cloud.resize(blobs.size(), degree);
  std::ranges::fill(cloud.sh, glm::vec3(0));
  for (std::size_t i = 0; i < blobs.size(); ++i) {
    const Blob& blob = blobs[i];
    cloud.positions[i] = blob.position;
    cloud.log_scales[i] = glm::log(blob.sigma);
    cloud.rotations[i] = blob.rotation;
    const double opacity = blob.opacity;
    cloud.opacity_logits[i] = static_cast<float>(std::log(opacity / (1 - opacity)));
    *sh_of(cloud, i) = (blob.color - 0.5f) / static_cast<float>(kSh0);
  }
  return cloud;
}

/// A camera at the origin that looks along +z.
Camera kit_camera(int width = kKitWidth, int height = kKitHeight,
                  glm::dvec2 focal_px = glm::dvec2(kKitFocal)) {
  return {.focal_px = focal_px,
          .center_px = 0.5 * glm::dvec2(width - 1, height - 1),
          .width = width,
          .height = height};
}

/// Rotation of a Gaussian about an axis by degrees.
glm::quat turned(glm::vec3 axis, float degrees) {
  return glm::angleAxis(glm::radians(degrees), glm::normalize(axis));
}

/// The point that camera `camera` shows at a pixel, at view depth z.
glm::vec3 world_point(const Camera& camera, glm::dvec2 pixel, double z) {
  const glm::dvec2 slope = (pixel - camera.center_px) / camera.focal_px;
  const glm::dvec3 view(slope.x * z, slope.y * z, z);
  const glm::dmat3 rotation(camera.view_from_world);
  return glm::vec3(camera.position() + glm::transpose(rotation) * view);
}

// Standard deviation, in world units, of a Gaussian that has `px` pixels at depth `z`.
float sigma_at(const Camera& camera, double px, double z) {
  return static_cast<float>(px * std::abs(z) / camera.focal_px.x);
}

// A round Gaussian at a pixel.
Blob round_blob(glm::dvec2 pixel, double z, double sigma_px, glm::vec3 color, float opacity = 0.9f,
                const Camera& camera = kit_camera()) {
  return {world_point(camera, pixel, z), glm::vec3(sigma_at(camera, sigma_px, z)), color, opacity};
}

// Two rows of three Gaussians: blob(i, pixel) for i = 0 to 5.
template <class MakeBlob>
std::vector<Blob> six_blobs(const MakeBlob& blob) {
  std::vector<Blob> blobs;
  for (int i = 0; i < 6; ++i) blobs.push_back(blob(i, {12 + 20 * (i % 3), 13 + 22 * (i / 3)}));
  return blobs;
}

// Sets the coefficients `first` to `last` of every Gaussian i to scale * wave(k, c, i), for each
// coefficient k and channel c.
template <class Wave>
void set_sh(KitView& view, int first, int last, float scale, const Wave& wave) {
  for (std::size_t i = 0; i < view.cloud.size(); ++i)
    for (int k = first; k <= last; ++k)
      for (int c = 0; c < 3; ++c)
        sh_of(view.cloud, i)[k][c] = scale * static_cast<float>(wave(k, c, static_cast<double>(i)));
}

KitView view_of(const std::vector<Blob>& blobs, const Camera& camera = kit_camera(),
                glm::vec3 background = glm::vec3(0)) {
  KitView view{cloud_of(blobs), camera, {}};
  view.settings.background = background;
  return view;
}

KitView one_gaussian() { return view_of({round_blob({22.3, 16.8}, 3, 6, {0.9f, 0.5f, 0.1f})}); }

KitView opacities() {
  const float opacity[] = {0.02f, 0.1f, 0.3f, 0.6f, 0.9f, 0.99f};
  return view_of(six_blobs([&](int i, glm::dvec2 pixel) {
    return round_blob(pixel, 3, 4, {1, 0.8f, 0.6f}, opacity[i]);
  }));
}

KitView occlusion() {
  return view_of({round_blob({28.3, 22.2}, 3.5, 7.2, {0.9f, 0.1f, 0.1f}),
                  round_blob({35.2, 27.4}, 2.5, 6.1, {0.1f, 0.2f, 0.9f}, 0.8f),
                  round_blob({24.4, 30.3}, 3, 6.3, {0.1f, 0.9f, 0.2f}, 0.7f)});
}

KitView small_gaussians(bool antialiased) {
  std::vector<Blob> blobs;
  for (int i = 0; i < 24; ++i) {
    const int column = i % 6, row = i / 6;
    blobs.push_back(round_blob({7.1 + 10.17 * column, 7.2 + 11.13 * row}, 3, 0.1 + 0.15 * row,
                               {1, 0.9f - 0.1f * static_cast<float>(column), 0.7}, 0.95f));
  }
  KitView view = view_of(blobs);
  view.cloud.antialiased = antialiased;
  return view;
}

// Many Gaussians in the same place make an effect visible that a rounding step hides for a single
// Gaussian.
KitView alpha_threshold() {
  std::vector<Blob> blobs(48, round_blob({17, 24}, 3, 7, glm::vec3(1), 0.0037f));
  blobs.resize(96, round_blob({47, 24}, 3, 7, glm::vec3(1), 0.0052f));
  return view_of(blobs);
}

// Gaussians whose 3-sigma square covers the picture, so that renderers that draw only that square
// give the same picture.
KitView alpha_maximum() {
  return view_of({round_blob({31.7, 24.2}, 2, 60, glm::vec3(0), 0.999999f),
                  round_blob({31.7, 24.2}, 3, 80, {6, 5, 4}, 0.98f)});
}

KitView transmittance_stop() {
  return view_of({round_blob({31.7, 24.2}, 2, 400, glm::vec3(0), 0.98f),
                  round_blob({31.7, 24.2}, 3, 400, glm::vec3(0), 0.98f),
                  round_blob({31.7, 24.2}, 4, 30, {300, 200, 100}, 0.9f),
                  round_blob({31.7, 24.2}, 5, 60, {200, 800, 400}, 0.5f)});
}

// No pixel with an alpha of 1/255 or more may be cut. The 3-sigma square covers all tiles of the
// picture.
KitView tails() {
  const Camera camera = kit_camera(80, 48);
  return view_of(
      std::vector<Blob>(16, round_blob({39.6, 23.4}, 3, 8.6, glm::vec3(0), 0.98f, camera)), camera,
      glm::vec3(1));
}

// Nine Gaussians in a wide field of view. Only the coefficients of one degree are set.
KitView spherical_harmonics(int degree) {
  const Camera camera = kit_camera(kKitWidth, kKitHeight, glm::dvec2(24));
  std::vector<Blob> blobs;
  for (int i = 0; i < 9; ++i)
    blobs.push_back(round_blob({11.2 + 20 * (i % 3), 7.9 + 15.6 * (i / 3)}, 3, 4, glm::vec3(0.5f),
                               0.95f, camera));
  KitView view{cloud_of(blobs, degree), camera, {}};
  set_sh(view, degree * degree, (degree + 1) * (degree + 1) - 1, 0.35f,
         [](int k, int c, double i) { return std::sin(1.0 + 1.7 * k + 2.3 * c + 0.9 * i); });
  return view;
}

KitView sh_degree_0() {
  return view_of(six_blobs([&](int i, glm::dvec2 pixel) {
    const auto c = static_cast<float>(i);
    return round_blob(pixel, 3, 4, {0.2f * c, 1 - 0.15f * c, 0.5f}, 0.95f);
  }));
}

KitView dark_colors() {
  return view_of({round_blob({24, 24}, 2.5, 7, {-0.8f, 0.4f, -0.3f}, 0.6f),
                  round_blob({40, 24}, 3, 7, {0.4f, -0.8f, -0.5f}, 0.7f)},
                 kit_camera(), {0.6f, 0.8f, 1});
}

KitView bright_colors() {
  return view_of({round_blob({24, 24}, 2.5, 7, {2.4f, 1.7f, 0.3f}, 0.35f),
                  round_blob({40, 24}, 3, 7, {0.3f, 1.4f, 2.2f}, 0.3f)});
}

std::vector<Blob> needles(float length_px, float width_px) {
  const glm::quat rotations[] = {turned({0, 0, 1}, 30),      turned({1, 2, 0.5}, 70),
                                 turned({0.3f, 1, -1}, 140), turned({-1, 0.4f, 2}, 50),
                                 turned({2, -1, 1}, 100),    turned({1, 1, 3}, -65)};
  return six_blobs([&](int i, glm::dvec2 pixel) {
    const auto c = static_cast<float>(i);
    Blob blob = round_blob(pixel, 3, 1, {1 - 0.15f * c, 0.5f, 0.2f + 0.15f * c});
    const float px = sigma_at(kit_camera(), 1, 3);
    blob.sigma = px * glm::vec3(length_px, width_px, 0.5f * (length_px + width_px));
    blob.rotation = rotations[i];
    return blob;
  });
}

KitView quaternions() { return view_of(needles(8, 1.5f)); }

KitView depth_ties() {
  return view_of({round_blob({26, 21}, 3, 7, {0.9f, 0.1f, 0.1f}),
                  round_blob({37, 22}, 3, 7, {0.1f, 0.9f, 0.1f}),
                  round_blob({31, 29}, 3, 7, {0.1f, 0.1f, 0.9f})});
}

KitView depth_or_distance() {
  const Camera camera = kit_camera(kKitWidth, kKitHeight, glm::dvec2(24));
  return view_of({round_blob({24, 22}, 2.2, 5, {0.9f, 0.2f, 0.1f}, 0.9f, camera),
                  round_blob({12, 25}, 2, 5, {0.1f, 0.3f, 0.9f}, 0.9f, camera),
                  round_blob({44, 30}, 2.2, 5, {0.2f, 0.9f, 0.1f}, 0.9f, camera),
                  round_blob({55, 38}, 2, 5, {0.9f, 0.1f, 0.8f}, 0.9f, camera)},
                 camera);
}

KitView near_plane() {
  return view_of({round_blob({20, 20}, 0.15, 6, {0.9f, 0.1f, 0.1f}),
                  round_blob({44, 20}, 0.25, 6, {0.1f, 0.9f, 0.1f}),
                  round_blob({32, 34}, -1, 6, {0.1f, 0.1f, 0.9f}),
                  round_blob({32, 32}, 3, 9, {0.6f, 0.6f, 0.6f}, 0.8f)});
}

KitView fov_clamp() {
  return view_of({{{-2.4f, 0.2f, 2}, glm::vec3(1), {0.9f, 0.5f, 0.2f}, 0.8f},
                  {{0.3f, 2.6f, 2.5f}, {0.8f, 1, 1.2f}, {0.2f, 0.5f, 0.9f}, 0.8f}});
}

KitView perspective() {
  const Camera camera = kit_camera(kKitWidth, kKitHeight, glm::dvec2(40));
  std::vector<Blob> blobs;
  for (int i = 0; i < 4; ++i) {
    Blob blob = round_blob({12 + 39 * (i % 2), 10 + 28 * (i / 2)}, 4, 1,
                           {0.9f - 0.2f * static_cast<float>(i), 0.6f, 0.3f}, 0.9f, camera);
    blob.sigma = {0.08f, 0.08f, 0.9f};  // long along the line of sight
    blobs.push_back(blob);
  }
  return view_of(blobs, camera);
}

// The needles before a camera that was moved and turned, with view-dependent colours.
KitView seen_from(const glm::dvec3& position, const glm::dvec3& up) {
  Camera camera = look_at(position, {0.1, 0.05, 2.9}, up, 1, kKitWidth, kKitHeight);
  camera.focal_px = glm::dvec2(kKitFocal);
  KitView view{cloud_of(needles(7, 2), 3), camera, {}};
  set_sh(view, 1, 15, 0.2f,
         [](int k, int c, double i) { return std::cos(2.0 + 1.1 * k + 1.9 * c + 0.7 * i); });
  return view;
}

KitView rotated_camera() { return seen_from({1.6, -1.2, 0.6}, {0.3, -1, 0.1}); }
KitView rolled_camera() { return seen_from({-0.4, 2.7, 1.7}, {1, 0.2, -0.3}); }

// Needles and round Gaussians all over a picture of this size.
KitView view_of_size(int width, int height, glm::dvec2 focal_px) {
  const Camera camera = kit_camera(width, height, focal_px);
  std::vector<Blob> blobs;
  for (int i = 0; i < 8; ++i) {
    const glm::dvec2 share(0.12 + 0.25 * (i % 4), i < 4 ? 0.3 : 0.72);
    Blob blob =
        round_blob(share * glm::dvec2(width, height), 3 + 0.1 * i, 3,
                   {0.2f + 0.1f * static_cast<float>(i), 0.8f - 0.1f * static_cast<float>(i), 0.5f},
                   0.9f, camera);
    blob.sigma.x *= 1.8f;
    blob.rotation = turned({0.2f, 0.1f, 1}, 25.0f * static_cast<float>(i));
    blobs.push_back(blob);
  }
  return view_of(blobs, camera);
}

KitView wide_picture() { return view_of_size(80, 32, {50, 38}); }
KitView tall_picture() { return view_of_size(32, 80, {38, 50}); }
KitView odd_size() { return view_of_size(61, 37, {53, 53}); }

KitView background() {
  KitView view = occlusion();
  view.settings.background = {0.2f, 0.6f, 0.4f};
  return view;
}

// Gaussians of all kinds, as in a trained scene.
KitView many() {
  const Camera camera = look_at({0.4, -0.3, -0.5}, {0.1, 0, 3}, {0.1, -1, 0.05}, 0.7, 80, 60);
  std::vector<Blob> blobs;
  std::uint64_t next = 0;
  const auto number = [&] { return static_cast<float>(Random{1}.uniform(next++)); };
  for (int i = 0; i < 160; ++i) {
    Blob blob;
    blob.position = {2.4f * number() - 1.2f, 1.8f * number() - 0.9f, 2 + 2 * number()};
    for (int axis = 0; axis < 3; ++axis) blob.sigma[axis] = std::exp(-4.5f + 2.8f * number());
    blob.color = {number(), number(), number()};
    blob.opacity = 0.02f + 0.8f * number();
    blob.rotation = turned(glm::vec3{number() - 0.5f, number() - 0.5f, number() + 0.01f},
                           360 * static_cast<float>(i) / 160);
    blobs.push_back(blob);
  }
  KitView view{cloud_of(blobs, 3), camera, {}};
  for (std::size_t i = 0; i < blobs.size(); ++i)
    for (int k = 1; k < 16; ++k)
      sh_of(view.cloud, i)[k] = 0.3f * (glm::vec3{number(), number(), number()} - 0.5f);
  return view;
}

constexpr KitScene kScenes[] = {
    {"one-gaussian", "position, size and falloff of one round Gaussian", one_gaussian},
    {"opacities", "Gaussians with opacities from 0.02 to 0.99", opacities},
    {"occlusion", "three Gaussians that overlap, not in order of depth in the file", occlusion},
    {"dilation", "Gaussians smaller than a pixel: 0.3 px^2 are added to both variances",
     [] { return small_gaussians(false); }},
    {"antialiased", "the same, trained with Mip-Splatting's opacity compensation",
     [] { return small_gaussians(true); }},
    {"alpha-threshold", "contributions with alpha below 1/255 are skipped", alpha_threshold},
    {"alpha-maximum", "alpha is at most 0.99", alpha_maximum},
    {"transmittance-stop", "a pixel stops before its transmittance falls below 0.0001",
     transmittance_stop},
    {"tails", "Gaussians end where alpha falls below 1/255, not earlier", tails},
    {"sh-degree-0", "colours without view dependence", sh_degree_0},
    {"sh-degree-1", "order, signs and directions of the coefficients of degree 1",
     [] { return spherical_harmonics(1); }},
    {"sh-degree-2", "the same for degree 2", [] { return spherical_harmonics(2); }},
    {"sh-degree-3", "the same for degree 3", [] { return spherical_harmonics(3); }},
    {"dark-colors", "colours of Gaussians below 0 become 0", dark_colors},
    {"bright-colors", "colours of Gaussians above 1 are kept until the picture is finished",
     bright_colors},
    {"quaternions", "rotations: the order w, x, y, z and their direction", quaternions},
    {"depth-ties", "at equal depth the first Gaussian of the file is in front", depth_ties},
    {"depth-or-distance", "Gaussians are sorted by depth along the view axis", depth_or_distance},
    {"near-plane", "Gaussians at depth 0.2 or below are not drawn", near_plane},
    {"fov-clamp", "beyond 1.3 x the field of view the Jacobian is evaluated at that limit",
     fov_clamp},
    {"perspective", "Gaussians that are long along the line of sight lean outwards", perspective},
    {"rotated-camera", "a camera that was moved and turned", rotated_camera},
    {"rolled-camera", "a camera that looks from below and is rolled", rolled_camera},
    {"wide-picture", "80 x 32 pixels with two focal lengths", wide_picture},
    {"tall-picture", "32 x 80 pixels with two focal lengths", tall_picture},
    {"odd-size", "61 x 37 pixels, no multiple of a tile", odd_size},
    {"background", "the background shows through with the remaining transmittance", background},
    {"many", "160 Gaussians of all kinds", many},
};

}  // namespace

std::span<const KitScene> kit_scenes() { return kScenes; }

}  // namespace qs
