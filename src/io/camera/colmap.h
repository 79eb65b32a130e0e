// SPDX-License-Identifier: MIT
//
// The parts that COLMAP's text and binary models share: a list of lenses (cameras.*), a list of
// images that use them (images.*), and the conversion of both to our cameras. Our principal point
// is COLMAP's minus 0.5: COLMAP counts from pixel corners, we count from pixel centres.
#pragma once

#include <cmath>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <glm/gtc/quaternion.hpp>
#include <glm/vec3.hpp>

#include "base/fail.h"
#include "io/camera/cameras.h"
#include "io/camera/lens.h"

namespace qs {

/// One of COLMAP's projections. The parameters begin with one or two focal lengths and the
/// principal point; the rest is distortion.
struct ColmapModel {
  int id;
  const char* name;
  int parameters, focal_lengths;
  bool pinhole;  ///< when its distortion is 0
  int known;     ///< the first parameters of its distortion that are k1, k2, p1, p2 of Lens
};

/// nullptr if there is no such model.
const ColmapModel* find_colmap_model(int id);
const ColmapModel* find_colmap_model(std::string_view name);

/// A lens: of the camera only size and intrinsics are set.
struct ColmapLensCamera {
  LensCamera camera;
  std::string not_finite;  ///< the sentence about a number that is not finite; empty: all are
};

/// Every lens by its id.
using ColmapLenses = std::map<std::uint32_t, ColmapLensCamera>;

/// A lens as the file stores it.
struct ColmapLens {
  std::uint32_t id;
  const ColmapModel& model;
  std::uint64_t width, height;         ///< pixels
  std::span<const double> parameters;  ///< model.parameters of them
};

/// Adds a lens. `where` names file and record; throws Error(input) for sizes and
/// numbers out of range, distortion that Lens lacks, and a second lens of one id.
void add_colmap_lens(ColmapLenses& lenses, const ColmapLens& stored, const std::string& where);

struct ColmapImage {
  glm::dquat rotation{1, 0, 0, 0};  ///< view from world, any length above 0
  glm::dvec3 translation{0};
  std::uint32_t lens = 0;
  std::string name = {};
};

/// The camera of an image. Throws Error(input), and NotFinite if its pose or its lens is not
/// finite.
LensCamera colmap_camera(const ColmapLenses& lenses, const ColmapImage& image,
                         const std::string& where);

// The values in the order of both kinds of files. A Source is a line of text or a binary record; it
// has read<T>(what), model() and where(), which names it in messages.

template <class Source>
void read_colmap_lens(Source& source, ColmapLenses& lenses) {
  const auto id = source.template read<std::uint32_t>("the camera's id");
  const ColmapModel& model = source.model();
  const auto width = source.template read<std::uint64_t>("the width");
  const auto height = source.template read<std::uint64_t>("the height");
  std::vector<double> parameters(static_cast<std::size_t>(model.parameters));
  for (double& parameter : parameters) parameter = source.template read<double>("a parameter");
  add_colmap_lens(lenses, {id, model, width, height, parameters}, source.where());
}

/// The image without its name.
template <class Source>
ColmapImage read_colmap_image(Source& source) {
  ColmapImage image;
  glm::dquat& q = image.rotation;
  source.template read<std::uint32_t>("the image's id");
  for (double* const value : {&q.w, &q.x, &q.y, &q.z})
    *value = source.template read<double>("the quaternion");
  for (int i = 0; i < 3; ++i)
    image.translation[i] = source.template read<double>("the translation");
  image.lens = source.template read<std::uint32_t>("the camera's id");
  return image;
}

template <class Source>
ScenePoint read_colmap_point(Source& source) {
  ScenePoint point;
  source.template read<std::uint64_t>("the point's id");
  for (int i = 0; i < 3; ++i) point.position[i] = source.template read<double>("the position");
  for (int i = 0; i < 3; ++i)
    point.color[i] = static_cast<float>(source.template read<std::uint8_t>("the colour")) / 255;
  for (int i = 0; i < 3; ++i)
    if (!std::isfinite(static_cast<float>(point.position[i])))
      fail("{}: its position is not finite", source.where());
  return point;
}

}  // namespace qs
