// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <limits>

#include <glm/gtc/quaternion.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>

#include "app/conformance/plain_renderer.h"
#include "app/picture/canvas.h"

namespace qs {
namespace {

// ---- rotations ----------------------------------------------------------------------------------

void quaternion_xyzw(Drawing& d) {
  for (glm::quat& q : d.view.cloud.rotations) q = glm::quat(q.z, q.w, q.x, q.y);
}

void quaternion_inverse(Drawing& d) {
  for (glm::quat& q : d.view.cloud.rotations) q = glm::conjugate(q);
}

void covariance_not_turned(Drawing& d) {
  // The camera's rotation cancels this rotation.
  const glm::quat world_from_view(
      glm::quat_cast(glm::transpose(glm::dmat3(d.view.camera.view_from_world))));
  for (glm::quat& q : d.view.cloud.rotations) q = glm::normalize(world_from_view * q);
}

// ---- spherical harmonics ------------------------------------------------------------------------

// Calls change(sh) for the coefficients of every Gaussian.
template <class Change>
void change_sh(Drawing& d, const Change& change) {
  GaussianCloud& cloud = d.view.cloud;
  const auto count = static_cast<std::size_t>(sh_coefficient_count(cloud.sh_degree));
  for (std::size_t i = 0; i < cloud.size(); ++i) change(cloud.sh.data() + i * count, count);
}

void sh_opposite(Drawing& d) {  // odd functions change their sign
  change_sh(d, [](glm::vec3* sh, std::size_t count) {
    for (std::size_t k = 1; k < count; ++k)
      if (k < 4 || k >= 9) sh[k] = -sh[k];
  });
}

void sh_signs(Drawing& d) {  // functions that 3DGS defines with a minus
  change_sh(d, [](glm::vec3* sh, std::size_t count) {
    for (const std::size_t k : {1u, 3u, 5u, 7u, 9u, 11u, 13u, 15u})
      if (k < count) sh[k] = -sh[k];
  });
}

void sh_interleaved(Drawing& d) {
  change_sh(d, [](glm::vec3* sh, std::size_t count) {
    const std::vector<glm::vec3> old(sh, sh + count);
    const auto value_of_file = [&](std::size_t i) {  // all of red, then green, then blue
      return old[1 + i % (count - 1)][static_cast<int>(i / (count - 1))];
    };
    for (std::size_t k = 1; k < count; ++k)
      for (std::size_t c = 0; c < 3; ++c)
        sh[k][static_cast<int>(c)] = value_of_file(3 * (k - 1) + c);
  });
}

// ---- colours ------------------------------------------------------------------------------------

// The image with change(value) for every value.
template <class Change>
Image changed(const Image& image, const Change& change) {
  Image result = image;
  for (float& value : result.values) value = change(std::clamp(value, 0.0f, 1.0f));
  return result;
}

Image encoded(const Image& image) {
  return changed(image, [](float v) {
    return v <= 0.0031308f ? 12.92f * v : 1.055f * std::pow(v, 1 / 2.4f) - 0.055f;
  });
}
Image decoded(const Image& image) {
  return changed(image, [](float v) {
    return v <= 0.04045f ? v / 12.92f : std::pow((v + 0.055f) / 1.055f, 2.4f);
  });
}
Image swapped_channels(const Image& image) {
  return picture_of(image.width, image.height,
                    [&](int x, int y, int c) { return image.at(x, y, 2 - c); });
}
Image mirrored(const Image& image) {
  return picture_of(image.width, image.height,
                    [&](int x, int y, int c) { return image.at(image.width - 1 - x, y, c); });
}
Image upside_down(const Image& image) {
  return picture_of(image.width, image.height,
                    [&](int x, int y, int c) { return image.at(x, image.height - 1 - y, c); });
}

// ---- cameras ------------------------------------------------------------------------------------

void camera_transposed(Drawing& d) {
  Camera& camera = d.view.camera;
  const glm::dvec3 position = camera.position();
  const glm::dmat3 wrong = glm::transpose(glm::dmat3(camera.view_from_world));
  camera.view_from_world = glm::dmat4x3(wrong[0], wrong[1], wrong[2], -(wrong * position));
}

constexpr Mistake kMistakes[] = {
    {"camera-transposed", "reads the camera's rotation as view from world", "camera",
     camera_transposed},
    {"quaternion-xyzw", "reads rot_0..3 as x, y, z, w instead of w, x, y, z", "rotation",
     quaternion_xyzw},
    {"quaternion-inverse", "turns Gaussians by the inverse rotation", "rotation",
     quaternion_inverse},
    {"covariance-not-turned", "does not turn covariances into view axes", "covariance",
     covariance_not_turned},
    {"sh-ignored", "ignores SH coefficients above degree 0", "sh",
     [](Drawing& d) { d.view.settings.sh_degree = 0; }},
    {"sh-up-to-1", "ignores SH coefficients above degree 1", "sh",
     [](Drawing& d) { d.view.settings.sh_degree = 1; }},
    {"sh-up-to-2", "ignores SH coefficients above degree 2", "sh",
     [](Drawing& d) { d.view.settings.sh_degree = 2; }},
    {"sh-opposite", "evaluates SH in the direction from the Gaussian to the camera", "sh",
     sh_opposite},
    {"sh-signs", "evaluates SH without the minus signs of 3DGS's basis", "sh", sh_signs},
    {"sh-interleaved", "reads f_rest as RGB triples instead of one channel after the other", "sh",
     sh_interleaved},
    {"sh-view-axes", "evaluates SH with directions in view axes instead of world axes", "sh",
     [](Drawing& d) { d.rules.view_directions = true; }},
    {"dark-not-clamped", "blends colours of Gaussians below 0", "dark",
     [](Drawing& d) { d.rules.clamps_dark = false; }},
    {"bright-clamped", "clamps colours of Gaussians to 1 before blending", "bright",
     [](Drawing& d) { d.rules.clamps_bright = true; }},
    {"bgr", "swaps red and blue", "channels",
     [](Drawing& d) { d.afterwards.push_back(swapped_channels); }},
    {"srgb-twice", "encodes the picture as sRGB although its colours are sRGB already", "transfer",
     [](Drawing& d) { d.afterwards.push_back(encoded); }},
    {"srgb-removed", "decodes the picture from sRGB to linear values", "transfer",
     [](Drawing& d) { d.afterwards.push_back(decoded); }},
    {"order-distance", "sorts by the distance from the camera instead of depth", "order",
     [](Drawing& d) { d.rules.order = Rules::Order::distance; }},
    {"order-reversed", "blends from back to front as if it were front to back", "order",
     [](Drawing& d) { d.rules.order = Rules::Order::depth_reversed; }},
    {"order-file", "does not sort: draws in the order of the file", "order",
     [](Drawing& d) { d.rules.order = Rules::Order::file; }},
    {"ties-reversed", "draws the last Gaussian of the file in front at equal depth", "ties",
     [](Drawing& d) { d.rules.reversed_ties = true; }},
    {"alpha-threshold-missing", "blends contributions with alpha below 1/255", "alpha min",
     [](Drawing& d) { d.rules.alpha_min = 0; }},
    {"alpha-not-limited", "does not limit alpha to 0.99", "alpha max",
     [](Drawing& d) { d.rules.alpha_max = 1; }},
    {"stop-missing", "blends behind a transmittance of 0.0001", "stop",
     [](Drawing& d) { d.rules.stop = Rules::Stop::never; }},
    {"stop-late", "blends the Gaussian that brings the transmittance below 0.0001, then stops",
     "stop", [](Drawing& d) { d.rules.stop = Rules::Stop::after; }},
    {"stop-early", "stops at a transmittance of 1/255 instead of 0.0001", "stop",
     [](Drawing& d) { d.rules.transmittance_min = 1.0 / 255; }},
    {"dilation-missing", "does not add 0.3 px^2 to the variances", "dilation",
     [](Drawing& d) { d.view.settings.dilation = 0; }},
    {"dilation-0.1", "adds 0.1 px^2 to the variances instead of 0.3", "dilation",
     [](Drawing& d) { d.view.settings.dilation = 0.1; }},
    {"compensation-missing", "ignores that a model is antialiased", "compensation",
     [](Drawing& d) { d.view.settings.antialiased = false; }},
    {"compensation-always", "treats every model as antialiased", "compensation",
     [](Drawing& d) { d.view.settings.antialiased = true; }},
    {"cut-3-sigma", "cuts Gaussians at 3 standard deviations", "extent",
     [](Drawing& d) { d.rules.cut_sigmas = 3; }},
    {"cut-sqrt8-sigma", "cuts Gaussians at sqrt(8) = 2.83 standard deviations", "extent",
     [](Drawing& d) { d.rules.cut_sigmas = std::sqrt(8.0); }},
    {"eigenvalue-floor",
     "draws ellipses with 3DGS's floor of 0.1 px^4 for their extent, and turns those along x",
     "eigenvalues", [](Drawing& d) { d.rules.eigenvalue_floor = kEigenvalueFloor; }},
    {"falloff-doubled", "computes exp(-d^2) instead of exp(-d^2 / 2)", "falloff",
     [](Drawing& d) { d.rules.falloff = 1; }},
    {"fov-clamp-missing", "evaluates the Jacobian beyond 1.3 x the field of view", "jacobian",
     [](Drawing& d) { d.rules.slope_limit = std::numeric_limits<double>::infinity(); }},
    {"jacobian-diagonal", "leaves out the slopes in the Jacobian of the projection", "jacobian",
     [](Drawing& d) { d.rules.slope_limit = 0; }},
    {"near-plane-missing", "draws Gaussians nearer than 0.2", "near plane",
     [](Drawing& d) { d.view.camera.near_depth = 0.01; }},
    {"one-focal-length", "uses the horizontal focal length for both axes", "focal",
     [](Drawing& d) { d.view.camera.focal_px.y = d.view.camera.focal_px.x; }},
    {"flipped-x", "mirrors the picture", "axes",
     [](Drawing& d) { d.afterwards.push_back(mirrored); }},
    {"flipped-y", "draws the picture upside down", "axes",
     [](Drawing& d) { d.afterwards.push_back(upside_down); }},
    {"half-pixel-right", "draws half a pixel too far to the right and the bottom", "pixel",
     [](Drawing& d) { d.view.camera.center_px += 0.5; }},
    {"half-pixel-left", "draws half a pixel too far to the left and the top", "pixel",
     [](Drawing& d) { d.view.camera.center_px -= 0.5; }},
    {"background-ignored", "draws a black background", "background",
     [](Drawing& d) { d.view.settings.background = glm::vec3(0); }},
};

}  // namespace

std::span<const Mistake> mistakes() { return kMistakes; }

std::vector<MistakeSet> sets_of_mistakes(int count) {
  if (count == 0) return {{}};
  std::vector<MistakeSet> sets;
  for (std::size_t a = 0; a < mistakes().size(); ++a) {
    if (count == 1) sets.push_back({a});
    for (std::size_t b = a + 1; count == 2 && b < mistakes().size(); ++b)
      if (mistakes()[a].part != mistakes()[b].part) sets.push_back({a, b});
  }
  return sets;
}

std::string names_of(const MistakeSet& set) {
  std::string names;
  for (const std::size_t i : set)
    names += (names.empty() ? "" : " + ") + std::string(mistakes()[i].name);
  return names.empty() ? "none" : names;
}

Image draw_with(const KitView& view, const MistakeSet& set, const Rules& rules) {
  Drawing drawing{view, rules};
  for (const std::size_t i : set) mistakes()[i].make(drawing);
  Image image =
      draw_plain(drawing.view.cloud, drawing.view.camera, drawing.view.settings, drawing.rules);
  for (const auto& change : drawing.afterwards) image = change(image);
  return image;
}

Picture8 picture8(const Image& image) {
  const Image rgb = picture_of(image.width, image.height, [&](int x, int y, int c) {
    return image.at(x, y, image.channels < 3 ? 0 : c);
  });
  Picture8 picture(rgb.values.size());
  std::ranges::transform(rgb.values, picture.begin(), to_8bit);
  return picture;
}

}  // namespace qs
