// SPDX-License-Identifier: MIT
//
// The parts that COLMAP's text and binary models share: a list of lenses (cameras.*), a list of
// images that use them (images.*), and the conversion of both to our cameras. Our principal point
// is COLMAP's minus 0.5: COLMAP counts from pixel corners, we count from pixel centres.
#pragma once

#include <cstdint>
#include <exception>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include <glm/gtc/quaternion.hpp>
#include <glm/vec3.hpp>

#include "base/fail.h"
#include "io/camera/cameras.h"
#include "io/camera/lens.h"

namespace qs {

/// A lens: of the camera only size and intrinsics are set.
struct ColmapLensCamera {
  LensCamera camera;
  std::exception_ptr error;  ///< null: none; it is thrown for an image that uses the lens
};

/// Every lens by its id.
using ColmapLenses = std::map<std::uint32_t, ColmapLensCamera>;

/// A lens as the file stores it.
struct ColmapLens {
  const LensModel& model;
  std::uint64_t width, height;     ///< pixels
  std::vector<double> parameters;  ///< model.parameters() of them
};

/// Without its limit, see checked_lens(). `where` names file and record. Throws Error(input) for
/// sizes out of range.
Lens colmap_lens(const ColmapLens& stored, const std::string& where);

/// The lens's parameters in the order of its model: the inverse of colmap_lens().
std::vector<double> colmap_parameters(const Lens& lens);

/// Adds the lens that make() returns. Its Error is kept for the images that use the lens.
template <class Make>
void add_colmap_lens(ColmapLenses& lenses, std::uint32_t id, const std::string& where,
                     const Make& make) {
  const auto [lens, is_new] = lenses.try_emplace(id);
  try {
    if (!is_new) fail("{}: there is another camera {}", where, id);
    lens->second.camera = make();
  } catch (const Error&) {
    lens->second.error = std::current_exception();
  }
}

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

/// The lens behind its id.
template <class Source>
ColmapLens read_colmap_lens(Source& source) {
  ColmapLens lens{source.model(), 0, 0, {}};
  lens.width = source.template read<std::uint64_t>("the width");
  lens.height = source.template read<std::uint64_t>("the height");
  for (int i = 0; i < lens.model.parameters(); ++i)
    lens.parameters.push_back(source.template read<double>("a parameter"));
  return lens;
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
  return point;
}

}  // namespace qs
