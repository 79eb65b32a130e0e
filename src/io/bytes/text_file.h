// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string>

namespace qs {

/// Writes the text to a file, or to stdout if the path is "-". Throws Error(input).
void write_text(const std::filesystem::path& path, const std::string& text);

}  // namespace qs
