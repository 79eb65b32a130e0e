// SPDX-License-Identifier: MIT
#include "app/serve/picture_message.h"

#include <algorithm>
#include <bit>
#include <cstring>

#include <glm/gtc/quaternion.hpp>

#include "app/viewer/render/resolution.h"

namespace qs {
namespace {

static_assert(std::endian::native == std::endian::little, "headers are little-endian");

template <class T>
void put(std::string& message, T value) {
  char bytes[sizeof(T)];
  std::memcpy(bytes, &value, sizeof(T));
  message.append(bytes, sizeof(T));
}

}  // namespace

std::size_t end_of_part(const Picture& picture, std::size_t begin) {
  const std::size_t size = picture.encoded.bytes.size();
  return picture.order.lossless ? std::min(begin + kPicturePart, size) : size;
}

std::string picture_message(const Picture& picture, const PictureNumbers& numbers,
                            std::size_t begin) {
  const std::size_t end = end_of_part(picture, begin);
  const FrameRequest& request = picture.order.request;
  const Camera camera =
      request.divisor > 1 ? reduced(request.camera, request.divisor) : request.camera;
  const std::uint8_t flags = static_cast<std::uint8_t>(
      (picture.encoded.is_key ? kKeyFlag : 0) | (picture.order.lossless ? kLosslessFlag : 0) |
      (end == picture.encoded.bytes.size() ? kLastPartFlag : 0) |
      (picture.is_last ? kLastStripFlag : 0));
  std::string message;
  message.reserve(kPictureHeader + end - begin);
  put(message, std::uint8_t{1});
  put(message, static_cast<std::uint8_t>(picture.encoded.codec));
  put(message, flags);
  put(message, static_cast<std::uint8_t>(request.divisor));
  put(message, numbers.picture);
  put(message, picture.order.input);
  put(message, numbers.state);
  put(message, static_cast<std::uint16_t>(picture.width));
  put(message, static_cast<std::uint16_t>(picture.height));
  put(message, static_cast<std::uint16_t>(picture.top));
  put(message, std::uint16_t{0});
  put(message, numbers.microseconds);
  const glm::dvec3 position = camera.position();
  for (int i = 0; i < 3; ++i) put(message, position[i]);
  const glm::dquat rotation = glm::quat_cast(glm::dmat3(camera.view_from_world));
  for (const double part : {rotation.x, rotation.y, rotation.z, rotation.w}) put(message, part);
  put(message, static_cast<float>(camera.focal_px.x));
  put(message, static_cast<float>(camera.focal_px.y));
  message.append(picture.encoded.bytes, begin, end - begin);
  return message;
}

}  // namespace qs
