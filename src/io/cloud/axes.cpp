// SPDX-License-Identifier: MIT
#include "io/cloud/axes.h"

#include <algorithm>
#include <array>

#include <glm/matrix.hpp>

namespace qs {
namespace {

// The direction of a letter in RDF; 0 for another letter.
glm::dvec3 direction_of(char letter) {
  constexpr std::string_view kLetters = "RLDUFB";
  glm::dvec3 direction(0);
  if (const std::size_t at = kLetters.find(letter); at != kLetters.npos)
    direction[static_cast<int>(at / 2)] = at % 2 == 0 ? 1 : -1;
  return direction;
}

}  // namespace

bool is_axes(std::string_view name) {
  return std::ranges::find(kAxes, name) != kAxes.end() ||
         (name.size() == 3 && glm::determinant(rdf_from(name)) == 1);
}

std::string turned_over(std::string_view name) {
  constexpr std::string_view kLetters = "DUFB", kOpposite = "UDBF";
  std::string turned(name);
  for (char& letter : turned)
    if (const auto at = kLetters.find(letter); at != kLetters.npos) letter = kOpposite[at];
  return turned;
}

glm::dmat3 rdf_from(std::string_view name) {
  return {direction_of(name[0]), direction_of(name[1]), direction_of(name[2])};
}

void flip_axes(GaussianCloud& cloud, std::size_t begin, std::size_t end, AxisSigns signs) {
  if (signs.is_identity()) return;
  const float x = signs.x, y = signs.y, z = signs.z;
  // D R D with D = diag(signs) is the rotation in the new frame, for either determinant of D.
  const glm::vec3 axis_signs(y * z, x * z, x * y);
  // Every real SH function of degree <= 3 is even or odd in each coordinate; the order is Y_0^0,
  // then m = -l..l per degree l, as in kernel/sh.h.
  const std::array<float, sh_coefficient_count(kMaxShDegree)> sh_signs = {
      1,     y,         z, x,         //
      x * y, y * z,     1, x * z, 1,  //
      y,     x * y * z, y, z,     x, z, x};

  const auto coefficients = static_cast<std::size_t>(sh_coefficient_count(cloud.sh_degree));
  for (std::size_t i = begin; i < end; ++i) {
    cloud.positions[i] *= glm::vec3(x, y, z);
    glm::quat& q = cloud.rotations[i];
    q = glm::quat(q.w, q.x * axis_signs.x, q.y * axis_signs.y, q.z * axis_signs.z);
    glm::vec3* const sh = &cloud.sh[i * coefficients];
    for (std::size_t k = 1; k < coefficients; ++k) sh[k] *= sh_signs[k];
  }
}

}  // namespace qs
