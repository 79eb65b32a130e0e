// SPDX-License-Identifier: MIT
#include "io/camera/lens_models.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <numbers>

#include <glm/geometric.hpp>

namespace qs {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kAhead = 0.5 * kPi - 1e-4;  // directions in front of the eye
constexpr double kAround = kPi;

// k1 s + k2 s^2 + ..
double series(double s, std::initializer_list<double> coefficients) {
  double sum = 0;
  for (auto k = std::rbegin(coefficients); k != std::rend(coefficients); ++k) sum = (sum + *k) * s;
  return sum;
}

glm::dvec2 tangential(glm::dvec2 p, double p1, double p2) {
  const double r2 = glm::dot(p, p);
  return {2 * p1 * p.x * p.y + p2 * (r2 + 2 * p.x * p.x),
          2 * p2 * p.x * p.y + p1 * (r2 + 2 * p.y * p.y)};
}

// A model with fewer coefficients has zeros in their places: Lens has twelve.

glm::dvec2 unbent(glm::dvec2 p, const double*) { return p; }

glm::dvec2 radial(glm::dvec2 p, const double* c) {
  return p * (1 + series(glm::dot(p, p), {c[0], c[1], c[2], c[3]}));
}

glm::dvec2 full_opencv(glm::dvec2 p, const double* c) {
  const double r2 = glm::dot(p, p);
  return p * ((1 + series(r2, {c[0], c[1], c[4]})) / (1 + series(r2, {c[5], c[6], c[7]}))) +
         tangential(p, c[2], c[3]);
}

glm::dvec2 brown_conrady(glm::dvec2 p, const double* c) {
  return p * (1 + series(glm::dot(p, p), {c[0], c[1], c[2]})) + tangential(p, c[3], c[4]);
}

// Metashape exchanges p1 and p2. Its b2 is `skew` times the focal length fx.
glm::dvec2 metashape(glm::dvec2 p, const double* c) {
  const glm::dvec2 bent = radial(p, c) + tangential(p, c[5], c[4]);
  return {bent.x + c[6] * bent.y, bent.y};
}

glm::dvec2 thin_prism(glm::dvec2 p, const double* c) {
  const double r2 = glm::dot(p, p);
  return p * (1 + series(r2, {c[0], c[1], c[4], c[5]})) + tangential(p, c[2], c[3]) +
         r2 * glm::dvec2(c[6], c[7]);
}

glm::dvec2 rad_tan_thin_prism(glm::dvec2 p, const double* c) {
  const glm::dvec2 q = p * (1 + series(glm::dot(p, p), {c[0], c[1], c[2], c[3], c[4], c[5]}));
  const double q2 = glm::dot(q, q);
  return q + tangential(q, c[7], c[6]) +
         glm::dvec2(series(q2, {c[8], c[9]}), series(q2, {c[10], c[11]}));
}

// A point of the plane `equidistant` as a direction of length 1: (x, y) and z.
struct Ray {
  glm::dvec2 xy;
  double z;

  explicit Ray(glm::dvec2 p) {
    const double angle = glm::length(p);
    xy = angle > 0 ? p * (std::sin(angle) / angle) : p;
    z = std::cos(angle);
  }
};

glm::dvec2 field_of_view(glm::dvec2 p, const double* c) {
  const double factor = 2 * std::tan(0.5 * c[0]), angle = glm::length(p);
  if (angle < 1e-9) return p * (factor / c[0]);
  return p * (std::atan2(factor * std::sin(angle), std::cos(angle)) / (c[0] * angle));
}

glm::dvec2 division(glm::dvec2 p, const double* c) {
  const Ray ray(p);
  return 2.0 * ray.xy / (ray.z + std::sqrt(ray.z * ray.z - 4 * c[0] * glm::dot(ray.xy, ray.xy)));
}

glm::dvec2 enhanced_unified(glm::dvec2 p, const double* c) {
  const Ray ray(p);
  const double distance = std::sqrt(c[1] * glm::dot(ray.xy, ray.xy) + ray.z * ray.z);
  return ray.xy / (c[0] * distance + (1 - c[0]) * ray.z);
}

using enum LensPlane;
constexpr const char* kRadTan = "k1 k2 k3 k4 k5 k6 p1 p2 s1 s2 s3 s4";
constexpr const char* kFull = "k1 k2 p1 p2 k3 k4 k5 k6";
constexpr std::array kLensModels = {
    LensModel{0, "SIMPLE_PINHOLE", 1, "", true, perspective, kAhead, unbent},
    LensModel{1, "PINHOLE", 2, "", true, perspective, kAhead, unbent},
    LensModel{2, "SIMPLE_RADIAL", 1, "k1", true, perspective, kAhead, radial},
    LensModel{3, "RADIAL", 1, "k1 k2", true, perspective, kAhead, radial},
    LensModel{4, "OPENCV", 2, "k1 k2 p1 p2", true, perspective, kAhead, full_opencv},
    LensModel{5, "OPENCV_FISHEYE", 2, "k1 k2 k3 k4", false, equidistant, kAround, radial},
    LensModel{6, "FULL_OPENCV", 2, kFull, true, perspective, kAhead, full_opencv},
    LensModel{7, "FOV", 2, "omega", false, equidistant, kAhead, field_of_view},
    LensModel{8, "SIMPLE_RADIAL_FISHEYE", 1, "k1", false, equidistant, kAround, radial},
    LensModel{9, "RADIAL_FISHEYE", 1, "k1 k2", false, equidistant, kAround, radial},
    LensModel{10, "THIN_PRISM_FISHEYE", 2, "k1 k2 p1 p2 k3 k4 sx1 sy1", false, equidistant, kAround,
              thin_prism},
    LensModel{11, "RAD_TAN_THIN_PRISM_FISHEYE", 2, kRadTan, false, equidistant, kAround,
              rad_tan_thin_prism},
    LensModel{12, "SIMPLE_DIVISION", 1, "k", true, equidistant, kAhead, division},
    LensModel{13, "DIVISION", 2, "k", true, equidistant, kAhead, division},
    LensModel{14, "SIMPLE_FISHEYE", 1, "", false, equidistant, kAround, unbent},
    LensModel{15, "FISHEYE", 2, "", false, equidistant, kAround, unbent},
    LensModel{16, "EUCM", 2, "alpha beta", false, equidistant, kAround, enhanced_unified},
    LensModel{17, "EQUIRECTANGULAR", 0, "", false, panorama, kAround, unbent},
    // Known by name alone. SPHERICAL is an old name, FISHEYE624 is nerfstudio's.
    LensModel{-1, "SPHERICAL", 0, "", false, panorama, kAround, unbent},
    LensModel{-1, "FISHEYE624", 2, kRadTan, false, equidistant, kAround, rad_tan_thin_prism},
    LensModel{-1, "BROWN_CONRADY", 1, "k1 k2 k3 p1 p2", true, perspective, kAhead, brown_conrady},
    LensModel{-1, "METASHAPE", 2, "k1 k2 k3 k4 p1 p2 skew", true, perspective, kAhead, metashape},
    LensModel{-1, "METASHAPE_FISHEYE", 2, "k1 k2 k3 k4 p1 p2 skew", false, equidistant, kAround,
              metashape},
};

}  // namespace

int LensModel::coefficients() const {
  return names.empty() ? 0 : static_cast<int>(std::ranges::count(names, ' ')) + 1;
}

int LensModel::parameters() const { return focal_lengths + 2 + coefficients(); }

std::string_view LensModel::coefficient(int i) const {
  std::string_view rest = names;
  for (; i > 0; --i) rest.remove_prefix(rest.find(' ') + 1);
  return rest.substr(0, rest.find(' '));
}

std::span<const LensModel> lens_models() { return kLensModels; }

const LensModel* find_lens_model(int id) {
  const auto* const found = std::ranges::find(kLensModels, id, &LensModel::id);
  return id < 0 || found == kLensModels.end() ? nullptr : found;
}

const LensModel* find_lens_model(std::string_view name) {
  const auto* const found = std::ranges::find(kLensModels, name, &LensModel::name);
  return found == kLensModels.end() ? nullptr : found;
}

glm::dvec2 to_plane(LensPlane plane, glm::dvec3 direction) {
  const glm::dvec2 xy(direction);
  const double z = direction.z;
  if (plane == perspective)
    return z > 0 ? xy / z : glm::dvec2(std::numeric_limits<double>::infinity());
  const double r = glm::length(xy);
  if (plane == panorama) return {std::atan2(xy.x, z), std::atan2(xy.y, std::hypot(xy.x, z))};
  if (r > 0) return xy * (std::atan2(r, z) / r);
  return {z > 0 ? 0 : kPi, 0};
}

glm::dvec3 from_plane(LensPlane plane, glm::dvec2 point) {
  if (plane == perspective) return {point, 1};
  if (plane == panorama)
    return {std::cos(point.y) * std::sin(point.x), std::sin(point.y),
            std::cos(point.y) * std::cos(point.x)};
  const Ray ray(point);
  return {ray.xy, ray.z};
}

BendDerivative bend_derivative(const LensModel& model, glm::dvec2 point,
                               const double* coefficients) {
  const double h = 1e-6 * std::max(1.0, glm::length(point));
  const auto along = [&](glm::dvec2 step) {
    return (model.bend(point + step, coefficients) - model.bend(point - step, coefficients)) /
           (2 * h);
  };
  return {along({h, 0}), along({0, h})};
}

double fold_radius(const LensModel& model, const double* coefficients) {
  if (model.plane == panorama) return std::numeric_limits<double>::infinity();
  constexpr int kRings = 360, kDirections = 16, kHalvings = 50;
  const auto radius = [&](double angle) {
    return model.plane == perspective ? std::tan(angle) : angle;
  };
  const auto is_clear = [&](double angle) {
    for (int i = 0; i < kDirections; ++i) {
      const double turn = 2 * kPi * i / kDirections;
      const glm::dvec2 point = radius(angle) * glm::dvec2(std::cos(turn), std::sin(turn));
      const double determinant = bend_derivative(model, point, coefficients).determinant();
      if (!std::isfinite(determinant) || determinant <= 0) return false;
    }
    return true;
  };
  double clear = 0;
  for (int ring = 1; ring <= kRings; ++ring) {
    double folded = model.widest * ring / kRings;
    if (is_clear(folded)) {
      clear = folded;
      continue;
    }
    for (int i = 0; i < kHalvings; ++i) {
      const double middle = 0.5 * (clear + folded);
      (is_clear(middle) ? clear : folded) = middle;
    }
    break;
  }
  return radius(clear);
}

}  // namespace qs
