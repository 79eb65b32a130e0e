// SPDX-License-Identifier: MIT
//
// The dialog Open without its drawing: typing, arrow keys and Enter in a real folder.
#include "app/viewer/panels/file_chooser.h"

#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/temporary_folder.h"

namespace qs {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;

class FileChooserTest : public testing::Test {
 protected:
  FileChooserTest() {
    for (const char* folder : {"rooms", "model/point_cloud/iteration_7", ".hidden"})
      fs::create_directories(folder_ / folder);
    for (const char* file : {"b.ply", "Attic.splat", "cameras.json", "notes.txt", "rooms/hall.spz",
                             "model/point_cloud/iteration_7/point_cloud.ply"})
      std::ofstream(folder_ / file) << std::string(1234, 'x');
    chooser_.start(folder_.path());
  }

  std::vector<std::string> names() const {
    std::vector<std::string> names;
    for (const FileEntry& row : chooser_.rows()) names.push_back(row.name);
    return names;
  }
  std::optional<fs::path> enter(const std::string& text) {
    chooser_.type(text);
    return chooser_.enter();
  }

  TemporaryFolder folder_;
  FileChooser chooser_;
};

TEST_F(FileChooserTest, lists_folders_then_readable_files_with_their_sizes) {
  EXPECT_THAT(names(),
              ElementsAre("../", "model/", "rooms/", "Attic.splat", "b.ply", "cameras.json"));
  EXPECT_EQ(chooser_.rows()[4].size, "1.2 kB");
  EXPECT_EQ(chooser_.rows()[1].size, "");
  EXPECT_EQ(chooser_.rows()[4].date.size(), std::string("2024-05-06").size());
}

TEST_F(FileChooserTest, typing_keeps_the_rows_that_match_in_any_case) {
  chooser_.type("at");
  EXPECT_THAT(names(), ElementsAre("Attic.splat"));
  chooser_.type("");
  EXPECT_EQ(names().size(), 6u);
}

TEST_F(FileChooserTest, a_typed_folder_is_listed_and_left_again) {
  chooser_.type("rooms/h");
  EXPECT_EQ(chooser_.folder(), folder_ / "rooms");
  EXPECT_THAT(names(), ElementsAre("hall.spz"));
  chooser_.type("room");
  EXPECT_EQ(chooser_.folder(), folder_.path());
  EXPECT_THAT(names(), ElementsAre("rooms/"));
  chooser_.type((folder_ / "rooms").string() + "/");
  EXPECT_THAT(names(), ElementsAre("../", "hall.spz"));
}

TEST_F(FileChooserTest, enter_opens_a_file_a_model_or_the_only_match) {
  EXPECT_EQ(enter("b.ply"), folder_ / "b.ply");
  EXPECT_EQ(enter("rooms/hall.spz"), folder_ / "rooms/hall.spz");
  EXPECT_EQ(enter("model"), folder_ / "model");
  EXPECT_EQ(enter("att"), folder_ / "Attic.splat");
  EXPECT_EQ(enter((folder_ / "b.ply").string()), folder_ / "b.ply");
}

TEST_F(FileChooserTest, the_first_of_several_matches_is_selected_while_typing_and_enter_opens_it) {
  std::ofstream(folder_ / "bb.ply") << "ply";
  chooser_.start(folder_.path());
  chooser_.type(".ply");
  ASSERT_THAT(names(), ElementsAre("b.ply", "bb.ply"));
  EXPECT_EQ(chooser_.selected(), 0);
  EXPECT_EQ(chooser_.enter(), folder_ / "b.ply");
  chooser_.type(".ply");
  chooser_.select(1);
  EXPECT_EQ(chooser_.enter(), folder_ / "bb.ply");
  chooser_.type("");
  EXPECT_EQ(chooser_.selected(), -1);
  EXPECT_EQ(enter("b.ply"), folder_ / "b.ply");
}

TEST_F(FileChooserTest, enter_lists_a_folder_without_a_scene_and_the_field_begins_again) {
  const int moves = chooser_.moves();
  EXPECT_EQ(enter("rooms"), std::nullopt);
  EXPECT_EQ(chooser_.folder(), folder_ / "rooms");
  EXPECT_EQ(chooser_.typed(), "");
  EXPECT_EQ(chooser_.moves(), moves + 1);
}

TEST_F(FileChooserTest, enter_names_what_does_not_exist) {
  EXPECT_EQ(enter("nothing.ply"), std::nullopt);
  EXPECT_THAT(chooser_.problem(), HasSubstr("nothing.ply does not exist"));
  chooser_.type("nothing.pl");
  EXPECT_EQ(chooser_.problem(), "");
  EXPECT_EQ(enter(""), std::nullopt);
}

TEST_F(FileChooserTest, for_a_folder_it_lists_folders_and_takes_the_typed_or_the_listed_one) {
  chooser_.start(folder_.path(), true);
  EXPECT_THAT(names(), testing::Each(testing::EndsWith("/")));
  EXPECT_THAT(names(), testing::Contains("rooms/"));
  EXPECT_EQ(enter(""), folder_.path()) << "the listed folder";
  EXPECT_EQ(enter("rooms"), folder_ / "rooms");
  EXPECT_EQ(enter("rooms/"), folder_ / "rooms");
  EXPECT_EQ(enter("model"), folder_ / "model");
  EXPECT_EQ(enter("b.ply"), std::nullopt);
  EXPECT_THAT(chooser_.problem(), HasSubstr("b.ply is a file: choose the folder"));
  EXPECT_EQ(enter("nothing/at/all"), std::nullopt);
  EXPECT_THAT(chooser_.problem(), HasSubstr("does not exist"));
  chooser_.type("rooms");
  chooser_.select(1);
  EXPECT_EQ(chooser_.enter(), std::nullopt) << "a row is entered";
  EXPECT_EQ(chooser_.folder(), folder_ / "rooms");
  EXPECT_EQ(enter(""), folder_ / "rooms");
  chooser_.start(folder_.path());
  EXPECT_THAT(names(), testing::Contains("b.ply"));
}

TEST_F(FileChooserTest, arrow_keys_select_rows_from_the_first_to_the_last) {
  EXPECT_EQ(chooser_.selected(), -1);
  chooser_.select(1);
  EXPECT_EQ(chooser_.selected(), 0);
  chooser_.select(-1);
  EXPECT_EQ(chooser_.selected(), 0);
  chooser_.select(100);
  EXPECT_EQ(chooser_.selected(), 5);
  EXPECT_EQ(chooser_.enter(), folder_ / "cameras.json");
  chooser_.type("rooms");
  EXPECT_EQ(chooser_.selected(), 0) << "the first match";
  chooser_.select(1);
  EXPECT_EQ(chooser_.enter(), std::nullopt);
  chooser_.select(1);
  EXPECT_EQ(chooser_.enter(), std::nullopt);  // ../
  EXPECT_EQ(chooser_.folder(), folder_.path());
  chooser_.type("matches nothing");
  chooser_.select(1);
  EXPECT_EQ(chooser_.selected(), -1);
}

}  // namespace
}  // namespace qs
