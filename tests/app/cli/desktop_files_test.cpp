// SPDX-License-Identifier: MIT
//
// The menu entry and the file types that an installation adds.
#include <filesystem>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "app/cli/command.h"
#include "base/text.h"
#include "io/bytes/json_text.h"
#include "support/paths.h"

namespace qs {
namespace {

std::string text_of(const char* name) {
  return read_text_file(test::source_path("cmake/desktop") / name, 1 << 20);
}

// All texts between `before` and `after`.
std::vector<std::string> between(const std::string& text, const std::string& before,
                                 const std::string& after) {
  std::vector<std::string> found;
  for (std::size_t at = 0; (at = text.find(before, at)) != text.npos;) {
    at += before.size();
    found.push_back(text.substr(at, text.find(after, at) - at));
  }
  return found;
}

TEST(DesktopFiles, the_menu_entry_opens_every_type_that_is_installed) {
  const auto types = between(text_of("quadsplat.xml"), "<mime-type type=\"", "\"");
  const auto lines = between(text_of("quadsplat.desktop"), "MimeType=", "\n");
  ASSERT_EQ(lines.size(), 1u);
  EXPECT_EQ(lines[0], joined(types, ";") + ";");
}

TEST(DesktopFiles, the_types_have_endings_that_are_read) {
  const auto globs = between(text_of("quadsplat.xml"), "<glob pattern=\"*", "\"");
  EXPECT_THAT(globs, testing::ElementsAre(".ply", ".spz", ".splat", ".ksplat", ".sog"));
  for (const std::string& ending : globs)
    EXPECT_THAT(format_list(), testing::ContainsRegex("[` ]\\" + ending + "[` ]"));
}

}  // namespace
}  // namespace qs
