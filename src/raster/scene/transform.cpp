// SPDX-License-Identifier: MIT
#include "raster/scene/transform.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <glm/common.hpp>
#include <glm/exponential.hpp>
#include <glm/geometric.hpp>
#include <glm/gtc/constants.hpp>
#include <glm/matrix.hpp>

#include "raster/kernel/constants.h"
#include "raster/kernel/sh.h"

namespace qs {
namespace {

// Calls visit(direction, weight) for a quadrature of the sphere that is exact for products of two
// functions of degree 3: Gauss-Legendre in z, equal steps in azimuth.
template <class Visit>
void integrate_sphere(const Visit& visit) {
  constexpr std::array kZ = {-0.8611363115940526, -0.3399810435848563, 0.3399810435848563,
                             0.8611363115940526};
  constexpr std::array kWeight = {0.3478548451374538, 0.6521451548625461, 0.6521451548625461,
                                  0.3478548451374538};
  constexpr int kSteps = 8;
  for (std::size_t i = 0; i < kZ.size(); ++i) {
    const double radius = std::sqrt(1 - kZ[i] * kZ[i]);
    for (int step = 0; step < kSteps; ++step) {
      const double angle = step * 2 * glm::pi<double>() / kSteps;
      visit(glm::dvec3(radius * std::cos(angle), radius * std::sin(angle), kZ[i]),
            kWeight[i] * 2 * glm::pi<double>() / kSteps);
    }
  }
}

// The orthogonal factor of the polar decomposition (Higham's iteration), mirrored when m is.
glm::dmat3 orthogonal_part(const glm::dmat3& m) {
  glm::dmat3 q = m;
  for (int i = 0; i < 60; ++i) {
    const glm::dmat3 inverse = glm::transpose(glm::inverse(q));
    const auto square = [](const glm::dmat3& a) {
      return glm::dot(a[0], a[0]) + glm::dot(a[1], a[1]) + glm::dot(a[2], a[2]);
    };
    const double factor = std::sqrt(std::sqrt(square(inverse) / square(q)));
    q = 0.5 * (factor * q + inverse / factor);
  }
  return q;
}

}  // namespace

void diagonalise(glm::dmat3 m, glm::dmat3& axes, glm::dvec3& values) {
  axes = glm::dmat3(1);
  for (int sweep = 0; sweep < 12; ++sweep) {
    for (int p = 0; p < 2; ++p) {
      for (int q = p + 1; q < 3; ++q) {
        if (std::abs(m[p][q]) <= 1e-18 * (std::abs(m[p][p]) + std::abs(m[q][q]))) continue;
        const double theta = (m[q][q] - m[p][p]) / (2 * m[p][q]);
        const double t = std::copysign(1 / (std::abs(theta) + std::sqrt(theta * theta + 1)), theta);
        const double c = 1 / std::sqrt(t * t + 1), s = t * c;
        // Turns rows and columns p and q. The third row and column, r, has two entries in them.
        const int r = 3 - p - q;
        m[p][p] -= t * m[p][q];
        m[q][q] += t * m[p][q];
        m[p][q] = m[q][p] = 0;
        const double rp = m[r][p], rq = m[r][q];
        m[r][p] = m[p][r] = c * rp - s * rq;
        m[r][q] = m[q][r] = s * rp + c * rq;
        const glm::dvec3 axis = axes[p];
        axes[p] = c * axis - s * axes[q];
        axes[q] = s * axis + c * axes[q];
      }
    }
  }
  values = {m[0][0], m[1][1], m[2][2]};
}

bool Transform::is_invertible(const glm::dmat4& matrix) {
  const bool is_affine =
      matrix[0][3] == 0 && matrix[1][3] == 0 && matrix[2][3] == 0 && matrix[3][3] == 1;
  const glm::dmat3 linear(matrix);
  const double longest =
      std::max({glm::length(linear[0]), glm::length(linear[1]), glm::length(linear[2])});
  const double volume = std::abs(glm::determinant(linear));
  return is_affine && std::isfinite(longest) && std::isfinite(volume) && longest > 1e-15 &&
         longest < 1e15 && volume > 1e-12 * longest * longest * longest;
}

Transform::Transform(const glm::dmat4& matrix) : matrix_(matrix), linear_(matrix) {
  const double volume = glm::determinant(linear_);
  const double scale = std::cbrt(std::abs(volume));
  const glm::dmat3 q = orthogonal_part(linear_);
  is_similarity_ = volume > 0;
  for (int column = 0; column < 3; ++column)
    if (glm::distance(linear_[column], scale * q[column]) > 1e-6 * scale) is_similarity_ = false;
  if (is_similarity_) {
    rotation_ = glm::normalize(glm::quat_cast(q));
    log_scale_ = static_cast<float>(std::log(scale));
  }
  // f'(d) = f(q^T d), projected on each basis function.
  integrate_sphere([&](const glm::dvec3& d, double weight) {
    std::array<double, 16> to, from;
    sh_basis(d, to.data());
    sh_basis(glm::transpose(q) * d, from.data());
    for (std::size_t l = 0; l <= kMaxShDegree; ++l)
      for (std::size_t k = 0; k < 2 * l + 1; ++k)
        for (std::size_t j = 0; j < 2 * l + 1; ++j)
          sh_[l][k][j] += static_cast<float>(weight * to[l * l + k] * from[l * l + j]);
  });
}

void Transform::turn_sh(glm::vec3* sh, int degree) const {
  for (std::size_t l = 1; l <= static_cast<std::size_t>(degree); ++l) {
    std::array<glm::vec3, 7> old;
    std::copy_n(sh + l * l, 2 * l + 1, old.begin());
    for (std::size_t k = 0; k < 2 * l + 1; ++k) {
      glm::vec3 sum(0);
      for (std::size_t j = 0; j < 2 * l + 1; ++j) sum += sh_[l][k][j] * old[j];
      sh[l * l + k] = sum;
    }
  }
}

void Transform::apply(GaussianCloud& cloud, std::size_t i) const {
  cloud.positions[i] = glm::vec3(matrix_ * glm::dvec4(glm::dvec3(cloud.positions[i]), 1));
  const glm::quat rotation = cloud.rotations[i];
  const glm::vec3 log_scale = cloud.log_scales[i];
  if (is_similarity_) {
    cloud.rotations[i] = glm::quat(rotation_ * glm::dquat(rotation));
    cloud.log_scales[i] = log_scale + log_scale_;
  } else {
    glm::dmat3 half = linear_ * glm::mat3_cast(glm::normalize(glm::dquat(rotation)));
    for (int axis = 0; axis < 3; ++axis)
      half[axis] *= std::exp(static_cast<double>(log_scale[axis]));
    set_covariance(cloud, i, half * glm::transpose(half));
  }
  turn_sh(&cloud.sh[i * static_cast<std::size_t>(sh_coefficient_count(cloud.sh_degree))],
          cloud.sh_degree);
}

void Placement::apply(GaussianCloud& cloud, std::size_t i) const {
  if (!transform.is_identity()) transform.apply(cloud, i);
  const auto count = static_cast<std::size_t>(sh_coefficient_count(cloud.sh_degree));
  glm::vec3* const sh = &cloud.sh[i * count];
  for (std::size_t k = 0; k < count; ++k) sh[k] *= tint;
  // Colours are 0.5 + kSh0 * DC + the other bands.
  sh[0] += (tint - 1.0f) * static_cast<float>(0.5 / kSh0);
}

void set_covariance(GaussianCloud& cloud, std::size_t i, const glm::dmat3& covariance) {
  glm::dmat3 axes;
  glm::dvec3 variances;
  diagonalise(covariance, axes, variances);
  if (glm::determinant(axes) < 0) axes[0] = -axes[0];
  cloud.rotations[i] = glm::quat(glm::normalize(glm::quat_cast(axes)));
  cloud.log_scales[i] = 0.5 * glm::log(glm::max(variances, 0.0));
}

}  // namespace qs
