// SPDX-License-Identifier: MIT
#include "app/remote/sibr_message.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <glm/glm.hpp>
#include <nlohmann/json.hpp>

#include "app/remote/tcp.h"

namespace qs {
namespace {

using Json = nlohmann::json;

constexpr double kMostPlace = 1e9, kMostScale = 100, kMostSkew = 0.01;
constexpr double kNearest = 0.01, kFarthest = 1000;  ///< of requests; trainers do not clip by them

// Null is NaN. Anything but a number makes `sound` false.
double real_of(const Json& value, bool& sound) {
  if (value.is_null()) return NAN;
  sound = sound && value.is_number();
  return value.is_number() ? value.get<double>() : NAN;
}

std::optional<int> side_of(const Json& object, const char* name) {
  const auto found = object.find(name);
  if (found == object.end() || !found->is_number_integer()) return {};
  const auto side = found->get<std::int64_t>();
  return side >= 0 && side <= kMostSibrSide ? std::optional(static_cast<int>(side)) : std::nullopt;
}

// OpenGL's perspective: x and y from -1 to 1 over the angles.
glm::dmat4 projection(const SibrRequest& request) {
  glm::dmat4 matrix(0.0);
  matrix[0][0] = 1 / std::tan(request.fov_x / 2);
  matrix[1][1] = 1 / std::tan(request.fov_y / 2);
  matrix[2][2] = -(kFarthest + kNearest) / (kFarthest - kNearest);
  matrix[2][3] = -1;
  matrix[3][2] = -2 * kFarthest * kNearest / (kFarthest - kNearest);
  return matrix;
}

std::string numbers_of(const glm::dmat4& matrix) {
  std::string text;
  for (int c = 0; c < 4; ++c)
    for (int r = 0; r < 4; ++r)
      text += fmt::format("{}{:.9g}", text.empty() ? "" : ",", matrix[c][r]);
  return text;
}

std::optional<double> number_in(const Json& object, const char* name) {
  const auto found = object.find(name);
  if (found == object.end() || !found->is_number()) return {};
  return found->get<double>();
}

constexpr std::size_t kLengthBytes = 4;

// A length of at most `most`, and that many bytes.
SibrEnd read_text(const ReadBytes& read, std::size_t most, std::string& text) {
  std::array<std::byte, kLengthBytes> length{};
  if (!read(length)) return SibrEnd::ended;
  const std::size_t size = length_of(length);
  if (size > most) return SibrEnd::foreign;
  text.resize(size);
  const bool is_whole = size == 0 || read(std::as_writable_bytes(std::span(text)));
  return is_whole ? SibrEnd::done : SibrEnd::ended;
}

// A trainer whose iterations are long may speak first after the request: then its list is in front
// of the first picture.
bool read_first_picture(const ReadBytes& read, SibrDialect& dialect, std::span<std::byte> rgb) {
  if (!read(rgb.first(kLengthBytes))) return false;
  const std::size_t size = length_of(rgb.first<kLengthBytes>());
  std::size_t known = kLengthBytes;
  if (size > 1 && size <= std::min(kMostSibrText, rgb.size() - kLengthBytes)) {
    if (!read(rgb.subspan(kLengthBytes, size))) return false;
    const std::string text(reinterpret_cast<const char*>(rgb.data()) + kLengthBytes, size);
    known += size;
    if (parse_render_modes(text)) {
      dialect = SibrDialect::trainer_first;
      known = 0;
    }
  }
  return known == rgb.size() || read(rgb.subspan(known));
}

}  // namespace

std::optional<SibrRequest> parse_sibr_request(std::string_view json) {
  const Json object = Json::parse(json, nullptr, false);
  if (!object.is_object()) return {};
  const std::optional<int> width = side_of(object, "resolution_x");
  const std::optional<int> height = side_of(object, "resolution_y");
  if (!width || !height) return {};
  SibrRequest request;
  request.width = *width;
  request.height = *height;
  if (request.width == 0 || request.height == 0) return request;
  bool sound = true;
  const auto real = [&](const char* name) {
    const auto found = object.find(name);
    sound = sound && found != object.end();
    return found == object.end() ? NAN : real_of(*found, sound);
  };
  request.fov_x = real("fov_x");
  request.fov_y = real("fov_y");
  request.splat_scale = real("scaling_modifier");
  const auto matrix = object.find("view_matrix");
  if (!sound || matrix == object.end() || !matrix->is_array() || matrix->size() != 16) return {};
  for (int i = 0; i < 16; ++i)
    request.view_from_world[i / 4][i % 4] = real_of((*matrix)[static_cast<std::size_t>(i)], sound);
  return sound ? std::optional(request) : std::nullopt;
}

std::optional<Camera> camera_of(const SibrRequest& request) {
  const auto is_angle = [](double angle) {
    return angle > 1e-4 && angle < std::numbers::pi - 1e-4;
  };
  if (request.width < 1 || request.height < 1) return {};
  if (!is_angle(request.fov_x) || !is_angle(request.fov_y)) return {};
  Camera camera;
  for (int c = 0; c < 4; ++c) {
    const glm::dvec4& column = request.view_from_world[c];
    camera.view_from_world[c] = {column.x, -column.y, -column.z};
  }
  const glm::dmat3 rotation(camera.view_from_world);
  const glm::dmat3 skew = glm::transpose(rotation) * rotation - glm::dmat3(1.0);
  for (int c = 0; c < 3; ++c) {
    for (int r = 0; r < 3; ++r)
      if (!(std::abs(skew[c][r]) <= kMostSkew)) return {};  // also NaN
    if (!(std::abs(camera.view_from_world[3][c]) <= kMostPlace)) return {};
  }
  if (glm::determinant(rotation) < 0) return {};
  camera.width = request.width;
  camera.height = request.height;
  camera.focal_px = {request.width / (2 * std::tan(request.fov_x / 2)),
                     request.height / (2 * std::tan(request.fov_y / 2))};
  camera.center_px = {(request.width - 1) / 2.0, (request.height - 1) / 2.0};
  return camera;
}

SibrRequest request_for(const Camera& camera) {
  SibrRequest request;
  request.width = std::clamp(camera.width, 1, kMostSibrSide);
  request.height = std::clamp(camera.height, 1, kMostSibrSide);
  request.fov_x = 2 * std::atan(camera.width / (2 * camera.focal_px.x));
  request.fov_y = 2 * std::atan(camera.height / (2 * camera.focal_px.y));
  for (int c = 0; c < 4; ++c) {
    const glm::dvec3& column = camera.view_from_world[c];
    request.view_from_world[c] = {column.x, -column.y, -column.z, c == 3 ? 1.0 : 0.0};
  }
  return request;
}

std::string sibr_message(const SibrRequest& request) {
  // "render_mode" is for trainers who speak first; others ignore it.
  return with_length(fmt::format(
      R"({{"resolution_x":{},"resolution_y":{},"train":{},"fov_y":{:.9g},"fov_x":{:.9g},)"
      R"("z_near":{:.9g},"z_far":{:.9g},"shs_python":0,"rot_scale_python":0,"keep_alive":{},)"
      R"("scaling_modifier":{:.9g},"render_mode":0,"view_matrix":[{}],)"
      R"("view_projection_matrix":[{}]}})",
      request.width, request.height, request.trains ? 1 : 0, request.fov_y, request.fov_x, kNearest,
      kFarthest, request.keeps_alive ? 1 : 0, request.splat_scale,
      numbers_of(request.view_from_world),
      numbers_of(projection(request) * request.view_from_world)));
}

std::optional<std::vector<std::string>> parse_render_modes(std::string_view json) {
  const Json list = Json::parse(json, nullptr, false);
  if (!list.is_array()) return {};
  std::vector<std::string> names;
  for (const Json& name : list) {
    if (!name.is_string()) return {};
    names.push_back(name.get<std::string>());
  }
  return names;
}

SibrMetrics parse_metrics(std::string_view json) {
  const Json object = Json::parse(json, nullptr, false);
  if (!object.is_object()) return {};
  return {number_in(object, "#"), number_in(object, "loss")};
}

// ---- the order of the bytes ---------------------------------------------------------------------
std::optional<SibrRequest> read_sibr_request(const ReadBytes& read) {
  std::string json;
  if (read_text(read, kMostSibrRequest, json) != SibrEnd::done) return {};
  return parse_sibr_request(json);
}

SibrEnd read_sibr_modes(const ReadBytes& read, SibrDialect& dialect) {
  std::string text;
  if (const SibrEnd end = read_text(read, kMostSibrText, text); end != SibrEnd::done) return end;
  if (!parse_render_modes(text)) return SibrEnd::foreign;
  dialect = SibrDialect::trainer_first;
  return SibrEnd::done;
}

SibrEnd read_sibr_answer(const ReadBytes& read, std::size_t rgb_bytes, bool is_first,
                         SibrDialect& dialect, SibrAnswer& answer) {
  answer.rgb.resize(rgb_bytes);
  const bool may_be_list =
      is_first && dialect != SibrDialect::trainer_first && rgb_bytes >= kLengthBytes;
  const bool is_whole =
      rgb_bytes == 0 ||
      (may_be_list ? read_first_picture(read, dialect, answer.rgb) : read(answer.rgb));
  if (!is_whole) return SibrEnd::ended;
  SibrEnd end = read_text(read, kMostSibrText, answer.source);
  if (end == SibrEnd::done && dialect == SibrDialect::trainer_first)
    end = read_text(read, kMostSibrText, answer.metrics);
  if (end == SibrEnd::done && dialect == SibrDialect::unknown) dialect = SibrDialect::viewer_first;
  return end;
}

}  // namespace qs
