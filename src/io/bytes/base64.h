// SPDX-License-Identifier: MIT
//
// Base64 (RFC 4648), and data URIs that hold it (RFC 2397), as glTF and HTML use them.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "raster/scene/gaussian_cloud.h"

namespace qs {

/// `bytes` in base64, padded with '='.
std::string base64(std::string_view bytes);

/// The bytes of "data:...;base64,...". Throws Error(input) "where: ..." for anything else.
Array<std::byte> decode_data_uri(std::string_view uri, const std::string& where);

}  // namespace qs
