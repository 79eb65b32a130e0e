// SPDX-License-Identifier: MIT
//
// The order of the bytes between trainers and their remote viewers, apart from sockets: what a
// server reads from a viewer, and what a viewer reads from a trainer. sibr_message.h has the
// content.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "app/remote/sibr_message.h"

namespace qs {

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
