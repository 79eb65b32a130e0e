// SPDX-License-Identifier: MIT
#include "app/serve/picture_message.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <string_view>

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

bool is_harmless(char c) {
  const bool letter = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
  return letter || std::string_view("._- ").find(c) != std::string_view::npos ||
         static_cast<unsigned char>(c) >= 0x80;
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
      request.divisor > 1 ? request.camera.reduced(request.divisor) : request.camera;
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

std::string harmless_name(const std::string& name) {
  std::string result = name.substr(name.find_last_of("/\\") + 1);
  std::ranges::replace_if(
      result, [](char c) { return !is_harmless(c); }, '_');
  result.erase(0, result.find_first_not_of(". "));
  constexpr std::size_t kMost = 200;
  if (result.size() > kMost) result.erase(0, result.size() - kMost);
  return result.empty() ? "file" : result;
}

std::string file_message(const SentFile& file, std::uint32_t number, std::size_t begin) {
  const std::string& bytes = *file.bytes;
  const std::size_t count = std::min(kFilePart, bytes.size() - begin);
  std::string message;
  put(message, std::uint8_t{2});
  put(message, static_cast<std::uint8_t>(begin + count == bytes.size() ? 4 : 0));
  put(message, static_cast<std::uint16_t>(file.name.size()));
  put(message, number);
  put(message, std::uint64_t{bytes.size()});
  return message + file.name + bytes.substr(begin, count);
}

}  // namespace qs
