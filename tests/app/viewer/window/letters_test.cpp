// SPDX-License-Identifier: MIT
#include "app/viewer/window/letters.h"

#include <cstdlib>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "app/support/driven_viewer.h"
#include "support/temporary_folder.h"

namespace qs {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

TEST(Letters, those_of_names_beyond_latin_are_collected_once) {
  Letters letters;
  EXPECT_FALSE(add_letters(letters, "garden.ply"));
  EXPECT_FALSE(add_letters(letters, "J\u00e4ger \u2013 \u2026 \u2212"));
  EXPECT_TRUE(add_letters(letters, "\u82b1\u5712.ply"));
  EXPECT_FALSE(add_letters(letters, "\u5712"));
  EXPECT_THAT(letters, ElementsAre(0x5712, 0x82b1));
  add_letters(letters, "\xff\xfe broken");
  EXPECT_THAT(letters, ElementsAre(0x5712, 0x82b1));
}

TEST(Letters, of_the_scene_of_recent_files_and_of_messages_are_shown) {
  test::DrivenScene driven(1);
  driven.apply([](Viewer& viewer) {
    viewer.scene->path = "/\u82b1.ply";
    viewer.scene->cameras[0].name = "\u5712";
    viewer.recent = {"/\u5ead.ply"};
  });
  driven.apply(action::notify, "wrote \u68ee.png");
  Letters letters;
  EXPECT_TRUE(add_shown_letters(letters, driven.viewer, FileChooser()));
  EXPECT_THAT(letters, ElementsAre(0x5712, 0x5ead, 0x68ee, 0x82b1));
  EXPECT_FALSE(add_shown_letters(letters, driven.viewer, FileChooser()));
}

TEST(Letters, become_ranges_of_glyphs) {
  const ImVector<ImWchar> ranges = glyph_ranges({0x82b1, 0x82b2, 0x5712});
  const std::vector<ImWchar> list(ranges.begin(), ranges.end());
  EXPECT_EQ(list[0], 0x20);
  EXPECT_THAT(list, testing::IsSupersetOf({0x5712, 0x82b1, 0x82b2, 0x2212, 0}));
}

// PATH with a program fc-match that writes a line, or without one.
TEST(Letters, their_font_is_the_one_that_fc_match_names) {
  const TemporaryFolder folder;
  const std::string before = std::getenv("PATH");
  setenv("PATH", folder.path().c_str(), 1);
  EXPECT_FALSE(system_font({0x82b1}));
  const std::filesystem::path program = folder / "fc-match";
  std::ofstream(program) << "#!/bin/sh\necho \"$3\" > " << (folder / "asked").string()
                         << "\nprintf '131074 /fonts/a b.ttc'\n";
  std::filesystem::permissions(program, std::filesystem::perms::owner_all);
  const auto font = system_font({0x5712, 0x82b1});
  setenv("PATH", before.c_str(), 1);
  ASSERT_TRUE(font);
  EXPECT_EQ(font->file, "/fonts/a b.ttc");
  EXPECT_EQ(font->index, 2) << "without the number of a variant";
  std::string asked;
  std::getline(std::ifstream(folder / "asked"), asked);
  EXPECT_EQ(asked, ":charset=5712 82b1 ");
}

}  // namespace
}  // namespace qs
