// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <vector>

#include <glm/glm.hpp>

#include "raster/scene/image_metrics.h"

namespace qs {
namespace {

constexpr std::size_t kErrorRows = 16;  // rows of a chunk

// The paper's constants: the exponent and the two knees of the colour difference, the exponent and
// the width in degrees of the feature difference.
constexpr double kColorExponent = 0.7, kColorKnee = 0.4, kColorKneeError = 0.95;
constexpr double kFeatureExponent = 0.5, kFeatureDegrees = 0.082;

// Contrast sensitivity of a channel: the sum of two Gaussians a sqrt(pi/b) exp(-(pi x)^2 / b), x in
// degrees.
struct Sensitivity {
  double a[2], b[2];
};
constexpr Sensitivity kSensitivities[3] = {{{1, 0}, {0.0047, 1e-5}},        // light and dark
                                           {{1, 0}, {0.0053, 1e-5}},        // red and green
                                           {{34.1, 13.5}, {0.04, 0.025}}};  // yellow and blue
constexpr double kWidestSensitivity = 0.04;

using Plane = std::vector<double>;

// --- colours -------------------------------------------------------------------------------------

// Linear sRGB to XYZ, D65; columns are the primaries.
const glm::dmat3 kXyz(glm::dvec3(10135552.0 / 24577794, 2613072.0 / 12288897, 1425312.0 / 73733382),
                      glm::dvec3(8788810.0 / 24577794, 8788810.0 / 12288897, 8788810.0 / 73733382),
                      glm::dvec3(4435075.0 / 24577794, 887015.0 / 12288897, 70074185.0 / 73733382));
const glm::dmat3 kRgb = glm::inverse(kXyz);
const glm::dvec3 kWhite = kXyz * glm::dvec3(1);

// The linear opponent space YCxCz: L* and a*, b* without the cube root.
glm::dvec3 opponent_of(glm::dvec3 linear) {
  const glm::dvec3 xyz = kXyz * linear / kWhite;
  return {116 * xyz.y - 16, 500 * (xyz.x - xyz.y), 200 * (xyz.y - xyz.z)};
}

glm::dvec3 linear_of_opponent(glm::dvec3 c) {
  const double y = (c.x + 16) / 116;
  return kRgb * (glm::dvec3(y + c.y / 500, y, y - c.z / 200) * kWhite);
}

// CIELab whose chroma shrinks in the dark (Hunt effect).
glm::dvec3 lab_of(glm::dvec3 linear) {
  const glm::dvec3 xyz = kXyz * linear / kWhite;
  const double x = lab_root(xyz.x), y = lab_root(xyz.y), z = lab_root(xyz.z);
  const double lightness = 116 * y - 16;
  return {lightness, 0.01 * lightness * 500 * (x - y), 0.01 * lightness * 200 * (y - z)};
}

// The distance HyAB to the power of kColorExponent.
double color_distance(glm::dvec3 a, glm::dvec3 b) {
  const glm::dvec3 d = a - b;
  return std::pow(std::abs(d.x) + std::hypot(d.y, d.z), kColorExponent);
}

// A distance as an error of 0 to 1: small distances take most of the range.
double color_error(double distance) {
  static const double largest = color_distance(lab_of({0, 1, 0}), lab_of({0, 0, 1}));
  const double knee = kColorKnee * largest;
  if (distance < knee) return kColorKneeError * distance / knee;
  return kColorKneeError + (1 - kColorKneeError) * (distance - knee) / (largest - knee);
}

// --- filters -------------------------------------------------------------------------------------

// Weights from -radius to +radius.
struct Filter {
  int radius = 0;
  std::vector<double> weights;
};

template <class F>
Filter sampled(int radius, F weight) {
  Filter filter{radius, {}};
  for (int i = -radius; i <= radius; ++i) filter.weights.push_back(weight(i));
  return filter;
}

double sum_of(const Filter& filter) {
  return std::accumulate(filter.weights.begin(), filter.weights.end(), 0.0);
}

// Scales the positive weights to the sum 1 and the negative weights to -1.
Filter balanced(Filter filter) {
  double positive = 0, negative = 0;
  for (const double weight : filter.weights) (weight > 0 ? positive : negative) += weight;
  for (double& weight : filter.weights) weight /= weight > 0 ? positive : -negative;
  return filter;
}

Filter normalised(Filter filter) {
  const double sum = sum_of(filter);
  for (double& weight : filter.weights) weight /= sum;
  return filter;
}

struct Size {
  int width = 0, height = 0;
  std::size_t at(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
           static_cast<std::size_t>(x);
  }
};

// Convolves rows, then columns. Pixels outside repeat the pixels of the border.
Plane filtered(const Plane& plane, Size size, const Filter& across, const Filter& down,
               ThreadPool& pool) {
  const auto pass = [&](const Plane& from, const Filter& filter, bool along_rows) {
    Plane to(from.size());
    pool.for_each(static_cast<std::size_t>(size.height), kErrorRows, [&](std::size_t row) {
      const int y = static_cast<int>(row);
      for (int x = 0; x < size.width; ++x) {
        double sum = 0;
        for (int k = -filter.radius; k <= filter.radius; ++k) {
          const int px = along_rows ? std::clamp(x + k, 0, size.width - 1) : x;
          const int py = along_rows ? y : std::clamp(y + k, 0, size.height - 1);
          sum +=
              filter.weights[static_cast<std::size_t>(k + filter.radius)] * from[size.at(px, py)];
        }
        to[size.at(x, y)] = sum;
      }
    });
    return to;
  };
  return pass(pass(plane, across, true), down, false);
}

// The channel as the eye resolves it. A Gaussian of two axes is the product of two of one axis.
Plane as_seen(const Plane& channel, Size size, const Sensitivity& sensitivity,
              double pixels_per_degree, ThreadPool& pool) {
  const double pi = std::acos(-1.0);
  const int radius = static_cast<int>(
      std::ceil(3 * std::sqrt(kWidestSensitivity / (2 * pi * pi)) * pixels_per_degree));
  Plane result(channel.size(), 0.0);
  double total = 0;
  for (int term = 0; term < 2; ++term) {
    if (sensitivity.a[term] == 0) continue;
    const Filter gaussian = sampled(radius, [&](int i) {
      const double degrees = i / pixels_per_degree;
      return std::exp(-pi * pi * degrees * degrees / sensitivity.b[term]);
    });
    const double height = sensitivity.a[term] * std::sqrt(pi / sensitivity.b[term]);
    total += height * sum_of(gaussian) * sum_of(gaussian);
    const Plane part = filtered(channel, size, gaussian, gaussian, pool);
    for (std::size_t i = 0; i < result.size(); ++i) result[i] += height * part[i];
  }
  for (double& value : result) value /= total;
  return result;
}

// --- the two differences -------------------------------------------------------------------------

struct Seen {
  std::vector<glm::dvec3> lab;  ///< filtered colours
  Plane edges, points;          ///< strengths of features
};

Plane strengths(const Plane& luminance, Size size, const Filter& detector, const Filter& smooth,
                ThreadPool& pool) {
  const Plane across = filtered(luminance, size, detector, smooth, pool);
  const Plane down = filtered(luminance, size, smooth, detector, pool);
  Plane result(across.size());
  for (std::size_t i = 0; i < result.size(); ++i) result[i] = std::hypot(across[i], down[i]);
  return result;
}

Seen seen(const Image& image, double pixels_per_degree, ThreadPool& pool) {
  const Size size{image.width, image.height};
  const std::size_t count = size.at(0, image.height);
  Plane channels[3] = {Plane(count), Plane(count), Plane(count)}, luminance(count);
  for (std::size_t i = 0; i < count; ++i) {
    const float* const pixel = &image.values[i * static_cast<std::size_t>(image.channels)];
    glm::dvec3 linear;
    for (int c = 0; c < 3; ++c) linear[c] = linear_of_srgb(std::clamp<double>(pixel[c], 0, 1));
    const glm::dvec3 opponent = opponent_of(linear);
    for (int c = 0; c < 3; ++c) channels[c][i] = opponent[c];
    luminance[i] = (opponent.x + 16) / 116;
  }
  for (int c = 0; c < 3; ++c)
    channels[c] = as_seen(channels[c], size, kSensitivities[c], pixels_per_degree, pool);

  Seen result;
  for (std::size_t i = 0; i < count; ++i) {
    const glm::dvec3 opponent(channels[0][i], channels[1][i], channels[2][i]);
    result.lab.push_back(lab_of(glm::clamp(linear_of_opponent(opponent), 0.0, 1.0)));
  }
  const double sigma = 0.5 * kFeatureDegrees * pixels_per_degree;
  const int radius = static_cast<int>(std::ceil(3 * sigma));
  const auto bell = [&](int i) { return std::exp(-0.5 * i * i / (sigma * sigma)); };
  const Filter smooth = normalised(sampled(radius, bell));
  const Filter edge = balanced(sampled(radius, [&](int i) { return -i * bell(i); }));
  const Filter point =
      balanced(sampled(radius, [&](int i) { return (i * i / (sigma * sigma) - 1) * bell(i); }));
  result.edges = strengths(luminance, size, edge, smooth, pool);
  result.points = strengths(luminance, size, point, smooth, pool);
  return result;
}

}  // namespace

double linear_of_srgb(double v) {
  return v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4);
}

double lab_root(double t) {
  constexpr double kDelta = 6.0 / 29;
  return t > kDelta * kDelta * kDelta ? std::cbrt(t) : t / (3 * kDelta * kDelta) + 4.0 / 29;
}

Image flip_map(const Image& reference, const Image& test, ThreadPool& pool,
               double pixels_per_degree) {
  assert(reference.width == test.width && reference.height == test.height);
  assert(reference.channels >= 3 && test.channels >= 3);
  const Seen a = seen(reference, pixels_per_degree, pool);
  const Seen b = seen(test, pixels_per_degree, pool);
  Image map(reference.width, reference.height, 1);
  for (std::size_t i = 0; i < map.values.size(); ++i) {
    const double color = color_error(color_distance(a.lab[i], b.lab[i]));
    const double feature =
        std::max(std::abs(a.edges[i] - b.edges[i]), std::abs(a.points[i] - b.points[i]));
    const double exponent = 1 - std::pow(feature / std::sqrt(2.0), kFeatureExponent);
    map.values[i] = static_cast<float>(std::pow(color, exponent));
  }
  return map;
}

double mean_flip(const Image& map) {
  return std::accumulate(map.values.begin(), map.values.end(), 0.0) /
         static_cast<double>(map.values.size());
}

double flip(const Image& reference, const Image& test, ThreadPool& pool, double pixels_per_degree) {
  return mean_flip(flip_map(reference, test, pool, pixels_per_degree));
}

}  // namespace qs
