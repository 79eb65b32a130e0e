// SPDX-License-Identifier: MIT
//
// Base64 in data URIs (RFC 2397, RFC 4648), as glTF has it.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "raster/scene/gaussian_cloud.h"

namespace qs {

/// The bytes of "data:...;base64,...". Throws Error(input) "where: ..." for anything else.
Array<std::byte> decode_data_uri(std::string_view uri, const std::string& where);

}  // namespace qs
