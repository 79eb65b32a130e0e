// SPDX-License-Identifier: MIT
//
// The tag by which viewers show a picture as a panorama: XMP of Google's GPano, see
// https://developers.google.com/streetview/spherical-metadata.
#pragma once

#include <filesystem>
#include <string>

namespace qs {

/// The entry of ImageMetadata that holds XMP. PNG and JPEG have it, other formats ignore it.
inline constexpr const char* kXmpText = "XML:com.adobe.xmp";

/// XMP for an equirectangular picture that shows `degrees` of 360, the middle ones.
std::string panorama_xmp(int width, int height, double degrees);

/// Adds XMP, of less than 65,000 bytes, to a JPEG file. `shown` names it in messages. Throws
/// Error(input).
void add_xmp(const std::filesystem::path& file, const std::filesystem::path& shown,
             const std::string& xmp);

}  // namespace qs
