// SPDX-License-Identifier: MIT
//
// The usual mistakes (docs/conformance.md), planted in the plugin that is installed as an example:
// template_mistakes.cmake puts calls of these functions into its source. The environment variable
// QS_MISTAKES names the mistakes with which a scene is opened, separated by commas. Without a
// mistake every function returns the example's own value.
// It is separate from app/conformance/mistakes.cpp, because these mistakes are parts of another
// renderer's source, which includes only quadsplat/plugin.h.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "quadsplat/plugin.h"

namespace planted {

using Names = std::set<std::string, std::less<>>;

/// The scene that the example keeps, with the mistakes with which it was opened.
struct Scene : QsScene {
  Names names;
  std::vector<float> covariances_of_rotations;
};

inline thread_local const Scene* current = nullptr;  // of the frame that this thread draws

inline bool has(const char* name) { return current->names.count(name) != 0; }

// ---- open, render -------------------------------------------------------------------------------

// The covariances from wrongly read rotations; empty if rotations are read correctly.
inline std::vector<float> turned_wrongly(const QsScene& scene, const Names& names) {
  const bool last = names.count("quaternion-xyzw") != 0;
  const bool inverse = names.count("quaternion-inverse") != 0;
  std::vector<float> covariances;
  for (std::uint64_t i = 0; (last || inverse) && i < scene.count; ++i) {
    const float* const q = scene.rotations + 4 * i;
    const double sign = inverse ? -1 : 1, w = last ? q[3] : q[0], x = sign * (last ? q[0] : q[1]),
                 y = sign * (last ? q[1] : q[2]), z = sign * (last ? q[2] : q[3]);
    const double r[3][3] = {{1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)},
                            {2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)},
                            {2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)}};
    for (int row = 0; row < 3; ++row) {
      for (int column = row; column < 3; ++column) {
        double sum = 0;
        for (int k = 0; k < 3; ++k)
          sum += r[row][k] * std::exp(2.0 * scene.log_scales[3 * i + k]) * r[column][k];
        covariances.push_back(static_cast<float>(sum));
      }
    }
  }
  return covariances;
}

inline QsScene* open(const QsScene& scene) {
  auto* const opened = new Scene{scene, {}, {}};
  const char* const names = std::getenv("QS_MISTAKES");
  std::istringstream words(names == nullptr ? "" : names);
  for (std::string word; std::getline(words, word, ',');) opened->names.insert(word);
  opened->covariances_of_rotations = turned_wrongly(scene, opened->names);
  if (!opened->covariances_of_rotations.empty())
    opened->covariances = opened->covariances_of_rotations.data();
  return opened;
}

inline void close(void* renderer) { delete static_cast<Scene*>(static_cast<QsScene*>(renderer)); }

inline void begin(void* renderer) {
  current = static_cast<Scene*>(static_cast<QsScene*>(renderer));
}

// The camera with the rotation's rows and columns exchanged keeps its position.
inline void transpose(double m[12]) {
  double eye[3], turned[9];
  for (int k = 0; k < 3; ++k) {
    eye[k] = -(m[k] * m[3] + m[4 + k] * m[7] + m[8 + k] * m[11]);
    for (int row = 0; row < 3; ++row) turned[3 * k + row] = m[4 * row + k];
  }
  for (int row = 0; row < 3; ++row) {
    const double* const r = turned + 3 * row;
    for (int k = 0; k < 3; ++k) m[4 * row + k] = r[k];
    m[4 * row + 3] = -(r[0] * eye[0] + r[1] * eye[1] + r[2] * eye[2]);
  }
}

inline QsView view(QsView v) {
  if (has("camera-transposed")) transpose(v.view_from_world);
  if (has("near-plane-missing")) v.near_depth = 0.01;
  if (has("one-focal-length")) v.focal_px[1] = v.focal_px[0];
  const double shift = has("half-pixel-right") ? 0.5 : has("half-pixel-left") ? -0.5 : 0;
  for (double& center : v.center_px) center += shift;
  if (has("dilation-missing")) v.dilation_px2 = 0;
  if (has("dilation-0.1")) v.dilation_px2 = 0.1;
  if (has("compensation-missing")) v.antialiased = 0;
  if (has("compensation-always")) v.antialiased = 1;
  if (has("sh-ignored")) v.sh_degree = 0;
  if (has("sh-up-to-1")) v.sh_degree = std::min(v.sh_degree, 1);
  if (has("sh-up-to-2")) v.sh_degree = std::min(v.sh_degree, 2);
  if (has("background-ignored")) v.background[0] = v.background[1] = v.background[2] = 0;
  return v;
}

inline float transferred(float value) {
  const float v = std::min(std::max(value, 0.0f), 1.0f);
  if (has("srgb-twice"))
    return v < 0.0031308f ? 12.92f * v : 1.055f * std::pow(v, 1 / 2.4f) - 0.055f;
  if (has("srgb-removed")) return v < 0.04045f ? v / 12.92f : std::pow((v + 0.055f) / 1.055f, 2.4f);
  return value;
}

inline void finish(const QsView& v, float* image) {
  const std::vector<float> drawn(image, image + std::size_t{3} * v.width * v.height);
  const bool mirrored = has("flipped-x"), upside_down = has("flipped-y"), bgr = has("bgr");
  for (int y = 0; y < v.height; ++y) {
    for (int x = 0; x < v.width; ++x) {
      const int to_x = mirrored ? v.width - 1 - x : x, to_y = upside_down ? v.height - 1 - y : y;
      for (int c = 0; c < 3; ++c)
        image[3 * (to_y * v.width + to_x) + (bgr ? 2 - c : c)] =
            transferred(drawn[3 * (y * v.width + x) + c]);
    }
  }
}

// ---- a Gaussian ---------------------------------------------------------------------------------

inline double turned(const double* m, int row, int k) {
  return has("covariance-not-turned") ? (row == k ? 1 : 0) : m[4 * row + k];
}

inline double slope_limit(double limit) {
  if (has("fov-clamp-missing")) return std::numeric_limits<double>::infinity();
  return has("jacobian-diagonal") ? 0 : limit;
}

// Gives the ellipse the eigenvalues that 3DGS computes for its extent, from its angle. False if an
// eigenvalue is not positive.
inline bool lengthen(double v[2][2], double& determinant) {
  if (!has("eigenvalue-floor")) return true;
  const double half = 0.5 * (v[0][0] + v[1][1]);
  const double spread = std::sqrt(std::max(0.1, half * half - determinant));
  const double major = half + spread, minor = half - spread;
  if (!(minor > 0)) return false;
  const bool along_x = std::abs(major - v[0][0]) + std::abs(v[0][1]) < 1e-5 * v[0][0];
  const double angle = along_x ? std::atan2(1.0, 0.0) : std::atan2(major - v[0][0], v[0][1]);
  const double c = std::cos(angle), s = std::sin(angle);
  v[0][0] = major * c * c + minor * s * s;
  v[1][1] = major * s * s + minor * c * c;
  v[0][1] = v[1][0] = (major - minor) * s * c;
  determinant = major * minor;
  return true;
}

inline double depth(const double t[3]) {
  if (has("order-distance")) return std::hypot(t[0], t[1], t[2]);
  if (has("order-reversed")) return -t[2];
  return has("order-file") ? 0 : t[2];
}

inline void turn_direction(const double t[3], double length, double d[3]) {
  for (int k = 0; k < 3; ++k) {
    if (has("sh-view-axes")) d[k] = t[k] / length;
    if (has("sh-opposite")) d[k] = -d[k];
  }
}

inline double coefficient(const QsScene& scene, int stored, std::uint64_t i, int k, int channel) {
  const float* const sh = scene.sh + 3 * i * static_cast<unsigned>(stored);
  if (k > 0 && has("sh-interleaved")) {
    const int at = 3 * (k - 1) + channel, rest = stored - 1;  // in the file: red, green, blue
    return sh[3 * (1 + at % rest) + at / rest];
  }
  const bool negative = has("sh-signs") && k % 2 == 1;  // 3DGS defines these functions with a minus
  return negative ? -sh[3 * k + channel] : sh[3 * k + channel];
}

inline double clamped(double color) {
  if (!has("dark-not-clamped")) color = std::max(color, 0.0);
  return has("bright-clamped") ? std::min(color, 1.0) : color;
}

// ---- a pixel: numbers, because they are asked for often -----------------------------------------

struct Pixel {
  double alpha_min = has("alpha-threshold-missing") ? 1e-9 : 1.0 / 255;
  double alpha_max = has("alpha-not-limited") ? 1 : 0.99;
  double transmittance_min = has("stop-missing") ? 0 : has("stop-early") ? 1.0 / 255 : 1e-4;
  double falloff = has("falloff-doubled") ? 2 : 1;
  double least_power = has("cut-3-sigma") ? -4.5 : has("cut-sqrt8-sigma") ? -4 : -1e9;
  bool stops_late = has("stop-late");
};

}  // namespace planted
