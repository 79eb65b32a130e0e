// SPDX-License-Identifier: MIT
#include "io/bytes/text_file.h"

#include <ostream>

#include <fmt/format.h>

#include "io/bytes/replace_file.h"

namespace qs {

void write_text(const std::filesystem::path& path, const std::string& text) {
  if (path == "-") {
    fmt::print("{}", text);
    return;
  }
  write_file(path, [&](std::ostream& file) { file << text; });
}

}  // namespace qs
