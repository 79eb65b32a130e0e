// SPDX-License-Identifier: MIT
//
// The messages between trainers and their remote viewers, as network_gui.py of the 3DGS code and
// RemotePointView.cpp of SIBR_viewers define them. The viewer sends a length (4 bytes,
// little-endian) and JSON; the trainer answers with width * height * 3 RGB bytes from the top row,
// none if a side is 0, and then with a length and ASCII text.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <glm/mat4x4.hpp>

#include "raster/scene/camera.h"

namespace qs {

/// The longest JSON of a request, bytes.
inline constexpr std::size_t kMostSibrRequest = 8192;
/// The longest side of a picture.
inline constexpr int kMostSibrSide = 4096;

struct SibrRequest {
  int width = 0, height = 0;        ///< pixels, 0 to kMostSibrSide; no picture if one is 0
  double fov_x = 0, fov_y = 0;      ///< radians
  glm::dmat4 view_from_world{1.0};  ///< axes x right, y up, z backward
  double splat_scale = 1;           ///< "scaling_modifier"
  bool trains = true;               ///< false: the trainer pauses
  bool keeps_alive = true;          ///< the trainer answers after its last iteration too
};

/// Unset if it is damaged: no JSON, a missing value, a side out of range. Does not throw. Numbers
/// that are not finite arrive as null and become NaN. Without a picture only the sides are read.
std::optional<SibrRequest> parse_sibr_request(std::string_view json);

/// The camera, with its principal point in the middle. Unset if a number is not finite or out of
/// range, or the view is not a rotation and a translation; so it is while the viewer has no scene.
std::optional<Camera> camera_of(const SibrRequest& request);

/// The request for the picture of a camera.
SibrRequest request_for(const Camera& camera);

/// The request with its length, to be sent by one call: trainers do not wait for a second part. It
/// fits a segment of Ethernet.
std::string sibr_message(const SibrRequest& request);

/// The names of the pictures that a trainer offers who speaks first ("2DGS"): a JSON list of texts.
/// Unset if it is not one.
std::optional<std::vector<std::string>> parse_render_modes(std::string_view json);

/// The numbers that such a trainer sends after each picture.
struct SibrMetrics {
  std::optional<double> gaussians, loss;
  bool operator==(const SibrMetrics&) const = default;
};
/// Empty if it is not a JSON object.
SibrMetrics parse_metrics(std::string_view json);

// ---- the order of the bytes ---------------------------------------------------------------------
// Apart from sockets: what a server reads from a viewer, and what a viewer reads from a trainer.

/// The longest text of a trainer, bytes.
inline constexpr std::size_t kMostSibrText = 65536;

/// Fills the bytes with the next ones of a connection; false if it has ended.
using ReadBytes = std::function<bool(std::span<std::byte> bytes)>;

/// `foreign`: the bytes are not of this protocol.
enum class SibrEnd { done, ended, foreign };

/// A viewer's next request: a length and JSON. Unset if the connection has ended, the length is
/// beyond kMostSibrRequest, or the JSON is damaged.
std::optional<SibrRequest> read_sibr_request(const ReadBytes& read);

/// INRIA's trainers wait for the viewer. The trainers of 2DGS speak first: a list of the pictures
/// that they offer, and numbers after each picture.
enum class SibrDialect { unknown, viewer_first, trainer_first };

/// A trainer's answer to a request.
struct SibrAnswer {
  std::vector<std::byte> rgb;  ///< rows from the top
  std::string source;          ///< folder of its data on its machine
  std::string metrics;         ///< JSON of a trainer who speaks first
};

/// The list of a trainer who speaks first: `dialect` becomes trainer_first.
SibrEnd read_sibr_modes(const ReadBytes& read, SibrDialect& dialect);

/// The answer to a request for `rgb_bytes` of a picture. `dialect`: of this trainer, which the
/// answer may show. `is_first`: nothing was read on this connection but a list of pictures.
SibrEnd read_sibr_answer(const ReadBytes& read, std::size_t rgb_bytes, bool is_first,
                         SibrDialect& dialect, SibrAnswer& answer);

}  // namespace qs
