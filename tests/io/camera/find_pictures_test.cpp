// SPDX-License-Identifier: MIT
// The rules by which photographs are found for the names in files of cameras, as a table.
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "io/camera/photographs.h"
#include "support/error_of.h"
#include "support/temporary_folder.h"

namespace qs {
namespace {

using testing::HasSubstr;

using Words = std::vector<std::string>;

class FindPictures : public testing::Test {
 protected:
  void touch(const std::string& name) const {
    std::filesystem::create_directories((folder_ / name).parent_path());
    std::ofstream(folder_ / name) << "x";
  }
  // The pictures of the names, relative to the folder; "none" for a name without a picture. Paths
  // count from `from`; without it the folder `images` alone is searched.
  Words found(const Words& names, const std::string& from = ".", bool may_share = false) const {
    const Photographs pictures(folder_ / "images");
    Words result;
    for (const auto& file : find_pictures(
             names, from.empty() ? std::filesystem::path() : folder_ / from, pictures, may_share))
      result.push_back(file.empty() ? "none" : file.lexically_relative(folder_.path()).string());
    return result;
  }

  TemporaryFolder folder_;
};

struct RuleRow {
  const char* rule;
  Words files, names, expected;
};

TEST_F(FindPictures, follow_the_rules) {
  const RuleRow rows[] = {
      {"a path from the file of cameras counts first",
       {"images/a.jpg", "left/a.jpg", "images/left/a.jpg"},
       {"left/a.jpg", "images/a.jpg"},
       {"left/a.jpg", "images/a.jpg"}},
      {"a path in the folder of photographs",
       {"images/l/a.jpg", "images/r/a.jpg"},
       {"r/a.jpg", "l/a.jpg"},
       {"images/r/a.jpg", "images/l/a.jpg"}},
      {"folders before the path are other machines'",
       {"images/l/a.jpg", "images/r/a.jpg"},
       {"/home/me/set/r/a.jpg", "C:/set/l/a.jpg"},
       {"images/r/a.jpg", "images/l/a.jpg"}},
      {"the name alone, if it is unique", {"images/a.jpg"}, {"some/where/a.jpg"}, {"images/a.jpg"}},
      {"the name alone, in a subfolder", {"images/l/a.jpg"}, {"a.jpg"}, {"images/l/a.jpg"}},
      {"a backslash separates folders",
       {"images/l/a.jpg", "images/r/a.jpg"},
       {"l\\a.jpg", "set\\r\\a.jpg"},
       {"images/l/a.jpg", "images/r/a.jpg"}},
      {"unless a file has it in its name",
       {"images/l\\a.jpg", "images/l/a.jpg"},
       {"l\\a.jpg"},
       {"images/l\\a.jpg"}},
      {"a missing ending",
       {"images/a.JPG", "images/b.png", "images/c.jpeg", "images/d.tif"},
       {"a", "b", "c", "d"},
       {"images/a.JPG", "images/b.png", "images/c.jpeg", "images/d.tif"}},
      {"another ending", {"images/a.png"}, {"a.jpg"}, {"images/a.png"}},
      {"the same ending before another",
       {"images/a.png", "images/a.jpg"},
       {"a.jpg", "a.png"},
       {"images/a.jpg", "images/a.png"}},
      {"other letters' case", {"images/L/A.JPG"}, {"l/a.jpg"}, {"images/L/A.JPG"}},
      {"the same letters' case before another",
       {"images/A.jpg", "images/a.jpg"},
       {"a.jpg", "A.jpg"},
       {"images/a.jpg", "images/A.jpg"}},
      {"dots in names",
       {"images/a.1.jpg", "images/a.2.jpg"},
       {"a.2.jpg", "a.1"},
       {"images/a.2.jpg", "images/a.1.jpg"}},
      {"blanks and other alphabets",
       {"images/my photo.jpg", "images/\xe5\x9b\xbe.jpg"},
       {"my photo.jpg", "\xe5\x9b\xbe.jpg"},
       {"images/my photo.jpg", "images/\xe5\x9b\xbe.jpg"}},
      {"./ and ../ are places",
       {"images/a.jpg", "left/b.jpg"},
       {"./images/a.jpg", "images/../left/b.jpg"},
       {"images/a.jpg", "left/b.jpg"}},
      {"the picture of another folder is another picture",
       {"images/l/a.jpg", "images/r/b.jpg"},
       {"r/a.jpg", "r/b.jpg"},
       {"none", "images/r/b.jpg"}},
      {"a picture that another name has is no picture of this one",
       {"images/l/a.jpg"},
       {"x/a.jpg", "l/a.jpg"},
       {"none", "images/l/a.jpg"}},
      {"no picture", {"images/a.jpg"}, {"b.jpg", "", "l/", "."}, {"none", "none", "none", "none"}},
      {"other files and hidden files are no pictures",
       {"images/a.txt", "images/.b.jpg", "images/._c.jpg", "images/.hidden/d.jpg"},
       {"a", "b", "c.jpg", "d.jpg"},
       {"none", "none", "none", "none"}},
  };
  for (const RuleRow& row : rows) {
    std::filesystem::remove_all(folder_ / "images");
    std::filesystem::remove_all(folder_ / "left");
    std::filesystem::create_directories(folder_ / "images");
    for (const std::string& file : row.files) touch(file);
    EXPECT_EQ(found(row.names), row.expected) << row.rule;
  }
}

TEST_F(FindPictures, names_that_stand_for_two_pictures_are_refused) {
  struct Row {
    Words files, names;
    const char* sentence;
  };
  const Row rows[] = {
      {{"images/l/a.jpg", "images/r/a.jpg"},
       {"a.jpg"},
       "two pictures are named like a.jpg: FOLDER/images/l/a.jpg and FOLDER/images/r/a.jpg"},
      {{"images/l/a.jpg", "images/r/a.jpg"}, {"set/a.jpg"}, "named like set/a.jpg"},
      {{"images/a.png", "images/a.jpg"}, {"a"}, "FOLDER/images/a.jpg and FOLDER/images/a.png"},
      {{"images/A.jpg", "images/A.JPG"}, {"a.jpg"}, "two pictures are named like a.jpg"},
      {{"images/a.jpg"},
       {"a.jpg", "a"},
       "FOLDER/images/a.jpg: one picture for two cameras, a.jpg "},
      {{"images/a.jpg"}, {"images/a.jpg", "./images/a.jpg"}, "one picture for two cameras"},
      {{"images/a.jpg"}, {"a.jpg", "A.JPG"}, "one picture for two cameras, a.jpg and A.JPG"},
  };
  for (const Row& row : rows) {
    std::filesystem::remove_all(folder_ / "images");
    for (const std::string& file : row.files) touch(file);
    std::string sentence = row.sentence;
    for (std::size_t at; (at = sentence.find("FOLDER")) != sentence.npos;)
      sentence.replace(at, 6, folder_.path().string());
    EXPECT_THAT(test::error_of([&] { found(row.names); }, ErrorKind::input), HasSubstr(sentence));
  }
  // Masks may be shared.
  touch("images/m.png");
  EXPECT_EQ(found({"m.png", "images/m.png"}, ".", true), Words({"images/m.png", "images/m.png"}));
}

TEST_F(FindPictures, links_are_followed_and_no_folder_is_listed_twice) {
  touch("elsewhere/deep/a.jpg");
  touch("elsewhere/b.jpg");
  std::filesystem::create_directories(folder_ / "images");
  std::filesystem::create_directory_symlink(folder_ / "elsewhere", folder_ / "images/linked");
  std::filesystem::create_directory_symlink(folder_ / "images", folder_ / "images/linked/loop");
  std::filesystem::create_symlink("nowhere", folder_ / "images/broken.png");
  std::filesystem::create_symlink(folder_ / "elsewhere/b.jpg", folder_ / "images/c.jpg");
  EXPECT_EQ(found({"deep/a.jpg", "c.jpg", "broken"}),
            Words({"images/linked/deep/a.jpg", "images/c.jpg", "none"}));
  EXPECT_EQ(Photographs(folder_ / "images").names(), Words({"c", "linked/b", "linked/deep/a"}));
  // Two links to one picture are one picture.
  EXPECT_THAT(test::error_of([&] {
                found({"c.jpg", "linked/b.jpg"});
              }),
              HasSubstr("one picture for two cameras"));
}

TEST_F(FindPictures, absolute_paths_count_if_they_exist) {
  touch("images/a.jpg");
  touch("other/a.jpg");
  EXPECT_EQ(found({(folder_ / "other/a.jpg").string()}), Words({"other/a.jpg"}));
  EXPECT_EQ(found({"/nowhere/other/a.jpg"}), Words({"images/a.jpg"}));
  // A folder that a user names has all photographs.
  EXPECT_EQ(found({(folder_ / "other/a.jpg").string()}, ""), Words({"images/a.jpg"}));
}

TEST_F(FindPictures, a_folder_that_is_none_is_refused) {
  touch("images/a.jpg");
  EXPECT_EQ(test::error_of([&] { Photographs(folder_ / "images/a.jpg"); }, folder_.path()),
            "images/a.jpg: not a folder of pictures");
}

TEST_F(FindPictures, the_folder_of_photographs_is_the_first_that_all_names_share) {
  touch("images/left/a.jpg");
  touch("rgb/a.jpg");
  struct Row {
    Words names;
    const char* folder;  // "": none
  };
  const Row rows[] = {
      {{"images/left/a.jpg", "images/b.jpg"}, "images"},
      {{"./images/a.jpg", "images\\b.jpg"}, "images"},
      {{"rgb/a", "rgb/b"}, "rgb"},
      {{"rgb/a", "images/b"}, ""},
      {{"a.jpg", "b.jpg"}, ""},
      {{"nowhere/a.jpg"}, ""},
      {{"/images/a.jpg"}, ""},
      {{}, ""},
  };
  for (const Row& row : rows) {
    const auto folder = shared_folder(row.names, folder_.path());
    EXPECT_EQ(folder ? folder->lexically_relative(folder_.path()).string() : "", row.folder)
        << (row.names.empty() ? "no names" : row.names[0]);
  }
}

}  // namespace
}  // namespace qs
