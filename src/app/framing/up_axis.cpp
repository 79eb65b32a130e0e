// SPDX-License-Identifier: MIT
#include "app/framing/up_axis.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>

#include <glm/geometric.hpp>
#include <glm/gtc/constants.hpp>
#include <glm/gtc/quaternion.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <glm/trigonometric.hpp>

#include "raster/scene/transform.h"

namespace qs {
namespace {

constexpr double kFarthestTilt =
    glm::radians(60.0);  ///< largest tilt of the estimate from the convention
constexpr double kTypicalTilt = glm::radians(35.0);
constexpr double kLargeSize = 0.01, kThickness = 0.015;  ///< shares of the subject's diagonal
constexpr std::size_t kMostPieces = 10'000;              ///< examined Gaussians
constexpr std::size_t kLeastPieces = 60;                 ///< fewer pieces are no plane
constexpr double kLeastShare = 0.1;   ///< the plane's least share of all Gaussians
constexpr double kUpsideDown = 1.25;  ///< times the score of the floor below

/// A Gaussian as a piece of a surface.
struct Piece {
  glm::dvec3 position, normal;
  double size;      ///< opacity times mean standard deviation in the surface, at most 1
  double flatness;  ///< 0 to 1

  /// The piece's vote for a plane with this normal: flat pieces parallel to the plane count most.
  double weight(glm::dvec3 plane_normal) const {
    const double cosine = glm::dot(normal, plane_normal), squared = cosine * cosine;
    return size * (0.2 + 0.8 * flatness * squared * squared);
  }
};

/// Large Gaussians count more than small ones, because a bare floor has few Gaussians. All
/// Gaussians with a standard deviation of at least `large` count alike, because surroundings have
/// huge Gaussians.
std::vector<Piece> pieces_of(const CloudSample& sample, const Subject& subject, double large) {
  std::vector<std::size_t> held;
  for (std::size_t i = 0; i < subject.holds.size(); ++i) {
    if (subject.holds[i]) held.push_back(i);
  }
  const std::size_t count = std::min(held.size(), kMostPieces);
  std::vector<Piece> pieces;
  for (std::size_t k = 0; k < count; ++k) {
    const std::size_t i = held[k * held.size() / count];
    const glm::dvec3 sigma = glm::exp(glm::dvec3(sample.gaussians.log_scales[i]));
    int thin = sigma.y < sigma.x ? 1 : 0;
    if (sigma.z < sigma[thin]) thin = 2;
    const double a = sigma[(thin + 1) % 3], b = sigma[(thin + 2) % 3];
    const double flatness = std::min(a, b) > 0 ? 1 - sigma[thin] / std::min(a, b) : 0;
    const glm::dmat3 turn =
        glm::mat3_cast(glm::normalize(glm::dquat(sample.gaussians.rotations[i])));
    pieces.push_back({glm::dvec3(sample.gaussians.positions[i]), turn[thin],
                      static_cast<double>(sample.opacities[i]) *
                          std::min(1.0, std::sqrt(a) * std::sqrt(b) / large),
                      flatness});
  }
  return pieces;
}

/// A plane and the weight of the pieces in it.
struct Plane {
  glm::dvec3 normal{0};
  double offset = 0, weight = 0;
  std::size_t pieces = 0;
  double score = 0;  ///< for comparisons of floors
};

/// The surfaces of a subject, and planes of their pieces that are at most `thickness_` away.
class Surfaces {
 public:
  /// A subject without an extent has no pieces.
  Surfaces(const CloudSample& sample, const Subject& subject) : middle_(subject.box.center()) {
    const double diagonal = glm::length(glm::dvec3(subject.box.size()));
    thickness_ = kThickness * diagonal;
    if (diagonal > 0 && std::isfinite(diagonal))
      pieces_ = pieces_of(sample, subject, kLargeSize * diagonal);
  }

  const std::vector<Piece>& pieces() const { return pieces_; }

  /// The approximate weight of the heaviest plane with this normal, from every second piece.
  double rough_weight(glm::dvec3 normal) const {
    constexpr int kHalf = 128, kBins = 2 * kHalf;
    double bins[kBins] = {};
    for (std::size_t i = 0; i < pieces_.size(); i += 2) {
      const double at = glm::dot(pieces_[i].position - middle_, normal) / thickness_;
      if (std::abs(at) < kHalf) bins[static_cast<int>(at + kHalf)] += pieces_[i].weight(normal);
    }
    double best = 0;
    for (int bin = 1; bin < kBins; ++bin) best = std::max(best, bins[bin - 1] + bins[bin]);
    return best;
  }

  /// The heaviest plane with about this normal, which is refined by ever nearer pieces.
  Plane plane_near(glm::dvec3 normal) const {
    constexpr int kRounds = 6;
    constexpr double kThinner = 0.75;
    double thickness = thickness_;
    for (int round = 0; round < kRounds; ++round, thickness *= kThinner) {
      const std::optional<glm::dvec3> refined =
          normal_of(heaviest_offset(normal, thickness), thickness);
      if (!refined) break;
      normal = glm::dot(*refined, normal) < 0 ? -*refined : *refined;
    }
    return heaviest_offset(normal, thickness_);
  }

 private:
  // Slides a window along the normal.
  Plane heaviest_offset(glm::dvec3 normal, double thickness) const {
    std::vector<std::pair<double, double>> offsets;  // with weights
    for (const Piece& piece : pieces_)
      offsets.emplace_back(glm::dot(piece.position, normal), piece.weight(normal));
    std::sort(offsets.begin(), offsets.end());
    Plane best{normal};
    double weight = 0;
    for (std::size_t last = 0, first = 0; last < offsets.size(); ++last) {
      weight += offsets[last].second;
      while (offsets[last].first - offsets[first].first > 2 * thickness)
        weight -= offsets[first++].second;
      if (weight > best.weight) {
        best.weight = weight;
        best.offset = 0.5 * (offsets[first].first + offsets[last].first);
        best.pieces = last - first + 1;
      }
    }
    return best;
  }

  // The direction in which the pieces of the plane spread least; empty if they do not spread out.
  std::optional<glm::dvec3> normal_of(const Plane& plane, double thickness) const {
    glm::dvec3 mean(0);
    double sum = 0;
    const auto for_members = [&](const auto& use) {
      for (const Piece& piece : pieces_) {
        if (std::abs(glm::dot(piece.position, plane.normal) - plane.offset) < 1.2 * thickness)
          use(piece.position, piece.weight(plane.normal));
      }
    };
    for_members([&](glm::dvec3 position, double weight) {
      mean += weight * position;
      sum += weight;
    });
    if (!(sum > 0)) return {};
    mean /= sum;
    glm::dmat3 spread(0);
    for_members([&](glm::dvec3 position, double weight) {
      spread += weight * glm::outerProduct(position - mean, position - mean);
    });
    const PrincipalAxes axes = principal_axes(spread);
    if (!(axes.value[0] < 0.3 * axes.value[1])) return {};
    return axes.axis[0];
  }

  std::vector<Piece> pieces_;
  glm::dvec3 middle_;
  double thickness_;
};

// Directions spread evenly over the cap around `pole`: a Fibonacci spiral.
std::vector<glm::dvec3> directions_around(glm::dvec3 pole, double angle, int count) {
  const glm::dvec3 other = std::abs(pole.x) < 0.5 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 0, 1);
  const glm::dvec3 x = glm::normalize(glm::cross(pole, other)), y = glm::cross(pole, x);
  std::vector<glm::dvec3> directions;
  for (int i = 0; i < count; ++i) {
    const double height = 1 - (1 - std::cos(angle)) * (i + 0.5) / count;
    const double turn = i * glm::pi<double>() * (3 - std::sqrt(5.0));
    const double radius = std::sqrt(1 - height * height);
    directions.push_back(height * pole + radius * (std::cos(turn) * x + std::sin(turn) * y));
  }
  return directions;
}

double tilt(glm::dvec3 a, glm::dvec3 b) { return std::acos(std::clamp(glm::dot(a, b), -1.0, 1.0)); }

// Planes far from the convention are less likely floors.
double likelihood(glm::dvec3 normal, double weight, glm::dvec3 convention) {
  const double tilts = tilt(normal, convention) / kTypicalTilt;
  return weight * std::exp(-0.5 * tilts * tilts);
}

// 1 for a floor, on which everything stands, to 1/2 for a roof.
double support(const Plane& plane, const std::vector<Piece>& pieces) {
  double above = 0, all = 1e-30;
  for (const Piece& piece : pieces) {
    const double height = glm::dot(piece.position, plane.normal) - plane.offset;
    above += std::max(height, 0.0) * piece.size;
    all += std::abs(height) * piece.size;
  }
  return 0.5 + 0.5 * above / all;
}

double score_of(const Plane& plane, const std::vector<Piece>& pieces, glm::dvec3 convention) {
  return likelihood(plane.normal, plane.weight, convention) * support(plane, pieces);
}

// The likeliest floor.
std::optional<Plane> find_floor(const Surfaces& surfaces, glm::dvec3 convention) {
  constexpr int kDirections = 500, kRefined = 4;
  std::vector<std::pair<double, glm::dvec3>> candidates;
  for (const glm::dvec3 normal : directions_around(convention, kFarthestTilt, kDirections))
    candidates.emplace_back(likelihood(normal, surfaces.rough_weight(normal), convention), normal);
  std::ranges::stable_sort(candidates, std::greater(), [](const auto& each) { return each.first; });
  Plane best;
  std::vector<glm::dvec3> tried;
  for (const auto& [unused, normal] : candidates) {
    const auto close = [&n = normal](glm::dvec3 other) { return glm::dot(n, other) > 0.97; };
    if (std::any_of(tried.begin(), tried.end(), close)) continue;
    if (tried.size() == kRefined) break;
    tried.push_back(normal);
    Plane plane = surfaces.plane_near(normal);
    plane.score = score_of(plane, surfaces.pieces(), convention);
    if (tilt(plane.normal, convention) <= kFarthestTilt && plane.score > best.score) best = plane;
  }
  double all = 0;
  for (const Piece& piece : surfaces.pieces()) all += piece.size;
  if (best.pieces < kLeastPieces || !(best.weight > kLeastShare * all)) return {};
  return best;
}

// The axis to which the pieces are perpendicular, of walls without a floor.
std::optional<glm::dvec3> axis_of_walls(const std::vector<Piece>& pieces, glm::dvec3 convention) {
  glm::dmat3 normals(0);
  for (const Piece& piece : pieces)
    normals += piece.size * piece.flatness * glm::outerProduct(piece.normal, piece.normal);
  const PrincipalAxes axes = principal_axes(normals);
  if (!(axes.value[0] < 0.2 * axes.value[1])) return {};
  const glm::dvec3 axis = glm::dot(axes.axis[0], convention) < 0 ? -axes.axis[0] : axes.axis[0];
  if (tilt(axis, convention) > kTypicalTilt) return {};
  return axis;
}

}  // namespace

glm::dvec3 world_up(std::string_view vertical_axis) {
  std::string_view axis = vertical_axis;
  const double sign = axis.starts_with('-') ? -1 : 1;
  if (axis.starts_with('-') || axis.starts_with('+')) axis.remove_prefix(1);
  if (axis == "x" || axis == "X") return {sign, 0, 0};
  if (axis == "y" || axis == "Y") return {0, sign, 0};
  if (axis == "z" || axis == "Z") return {0, 0, sign};
  return {0, -1, 0};
}

UpEstimate estimate_up(const CloudSample& sample, const Subject& subject, glm::dvec3 convention) {
  const Surfaces surfaces(sample, subject);
  if (surfaces.pieces().size() < kLeastPieces) return {convention};
  std::optional<Plane> below = find_floor(surfaces, convention);
  glm::dvec3 up = convention;
  if (below) {
    up = below->normal;
    below->score = score_of(*below, surfaces.pieces(), up);
  } else if (const auto axis = axis_of_walls(surfaces.pieces(), convention)) {
    up = *axis;
    below = find_floor(surfaces, up);
  }
  const std::optional<Plane> above = find_floor(surfaces, -up);
  return {up, above && (!below || above->score > kUpsideDown * below->score), above || below};
}

PrincipalAxes principal_axes(const glm::dmat3& matrix) {
  glm::dmat3 axes;
  glm::dvec3 values;
  diagonalise(matrix, axes, values);
  int order[] = {0, 1, 2};
  std::ranges::sort(order, {}, [&](int i) { return values[i]; });
  PrincipalAxes result;
  for (int i = 0; i < 3; ++i) {
    result.axis[i] = axes[order[i]];
    result.value[i] = values[order[i]];
  }
  return result;
}

}  // namespace qs
