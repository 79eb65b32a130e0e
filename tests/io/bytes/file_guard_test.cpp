// SPDX-License-Identifier: MIT
//
// The files that a command may write: never an input, and an existing one only if this program
// wrote it as a picture or report, or with permission.
#include "io/bytes/file_guard.h"

#include <fstream>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "io/bytes/json_text.h"
#include "io/bytes/mapped_file.h"
#include "io/bytes/replace_file.h"
#include "io/picture/image_file.h"
#include "support/error_of.h"
#include "support/temporary_folder.h"

namespace qs {
namespace {

namespace fs = std::filesystem;
using test::error_of;
using testing::HasSubstr;

class Guarded : public testing::Test {
 protected:
  fs::path write(const std::string& name, const std::string& text = "somebody's") const {
    std::ofstream(folder_ / name) << text;
    return folder_ / name;
  }
  static std::string text_of(const fs::path& path) {
    std::ifstream file(path);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  static std::string replace(const fs::path& path) {
    return error_of([&] { write_file(path, [](std::ostream& file) { file << "new"; }); },
                    ErrorKind::usage);
  }

  TemporaryFolder folder_;
};

TEST_F(Guarded, an_input_is_not_written_under_any_name) {
  const fs::path input = write("scene.ply");
  fs::create_symlink(input, folder_ / "link.ply");
  fs::create_hard_link(input, folder_ / "hard.ply");
  fs::create_directory(folder_ / "sub");
  for (const bool overwrite : {false, true}) {
    const FileGuard guard(overwrite);
    const MappedFile read(input);
    for (const char* name : {"scene.ply", "link.ply", "hard.ply", "sub/../scene.ply"}) {
      EXPECT_THAT(replace(folder_ / name), HasSubstr("is an input of this command")) << name;
    }
  }
  EXPECT_EQ(text_of(input), "somebody's");
  EXPECT_EQ(replace(input), "");  // the command is over
}

TEST_F(Guarded, every_way_to_read_a_file_makes_it_an_input) {
  const fs::path text = write("a.txt"), mapped = write("b.bin"), picture = folder_ / "c.pfm";
  write_image(Image(2, 2, 3), picture);
  const FileGuard guard(true);
  read_text_file(text, 100);
  const MappedFile kept(mapped);
  read_image(picture);
  for (const fs::path& path : {text, mapped, picture})
    EXPECT_THAT(replace(path), HasSubstr("is an input")) << path;
}

TEST_F(Guarded, a_file_of_someone_else_needs_permission) {
  const fs::path scene = write("scene.ply"), table = write("bench.csv", "day,rain\n1,2\n");
  {
    const FileGuard guard(false);
    for (const fs::path& path : {scene, table}) {
      EXPECT_EQ(error_of([&] { check_target(path); }, folder_.path()),
                path.filename().string() +
                    ": exists already: choose another name, or replace it with --overwrite");
      EXPECT_THAT(replace(path), HasSubstr("exists already"));
    }
    EXPECT_EQ(guard.replaced(), 0u);
  }
  EXPECT_EQ(text_of(table), "day,rain\n1,2\n");
  const FileGuard guard(true);
  EXPECT_EQ(replace(scene), "");
  EXPECT_EQ(guard.replaced(), 1u);
  EXPECT_EQ(replace(scene), "");  // its own file
  EXPECT_EQ(guard.replaced(), 1u);
  EXPECT_EQ(written_files().count, 2u);
}

TEST_F(Guarded, own_pictures_and_reports_are_replaced_and_counted) {
  write_image(Image(2, 2, 3), folder_ / "own.png");
  write("own.csv", "scene,camera,mode,pipeline,backend\na,0,3dgs,fast,cpu\n");
  write("foreign.png", "\x89PNG");
  const FileGuard guard(false);
  for (int i = 1; i <= 2; ++i) {
    write_image(Image(1, 1, 1), folder_ / "own.png");
    EXPECT_EQ(replace(folder_ / "own.csv"), "");
    EXPECT_EQ(guard.replaced(), 2u);
  }
  EXPECT_THAT(error_of([&] { write_image(Image(1, 1, 1), folder_ / "foreign.png"); }),
              HasSubstr("foreign.png: exists already"));
  EXPECT_FALSE(is_own_report(folder_ / "missing.png"));
}

TEST_F(Guarded, what_a_run_owns_it_may_replace_but_not_its_inputs) {
  fs::create_directory(folder_ / "model");
  const fs::path checkpoint = write("model/checkpoint"), log = write("model/train.csv");
  const FileGuard guard(false);
  note_own(folder_ / "model");
  EXPECT_EQ(replace(log), "");
  { const MappedFile read(checkpoint); }
  EXPECT_THAT(replace(checkpoint), HasSubstr("is an input"));
  note_own(checkpoint);
  EXPECT_EQ(replace(checkpoint), "");
  EXPECT_EQ(guard.replaced(), 0u);
}

TEST_F(Guarded, a_name_of_its_own_is_free_or_of_a_file_that_this_program_wrote) {
  const fs::path path = folder_ / "garden_path.json";
  EXPECT_EQ(own_name(path), path);
  write("garden_path.json", "[{\"id\": 0, \"written_by\": \"quadsplat\"}]");
  EXPECT_EQ(own_name(path), path);
  write("garden_path.json", "[{\"id\": 0}]");
  EXPECT_EQ(own_name(path), folder_ / "garden_path_0001.json");
  write("garden_path_0001.json", "somebody's, too");
  EXPECT_EQ(own_name(path), folder_ / "garden_path_0002.json");
  write("garden_path_0002.json", "[{\"id\": 0, \"written_by\": \"quadsplat\"}]");
  EXPECT_EQ(own_name(path), folder_ / "garden_path_0002.json");
  fs::create_symlink(folder_ / "nowhere", folder_ / "link.json");
  EXPECT_EQ(own_name(folder_ / "link.json"), folder_ / "link_0001.json");
}

TEST_F(Guarded, a_folder_appears_whole_or_not_at_all) {
  const fs::path target = folder_ / "new/report";
  const auto write_two = [](const fs::path& hidden) {
    write_file(hidden / "a.txt", [](std::ostream& file) { file << "a"; });
    fs::create_directory(hidden / "sub");
    write_file(hidden / "sub/b.txt", [](std::ostream& file) { file << "b"; });
  };
  const FileGuard guard(false);
  EXPECT_EQ(error_of([&] {
              replace_folder(target, [&](const fs::path& hidden) {
                write_two(hidden);
                throw Error(ErrorKind::input, hidden.string() + "/a.txt: the disk is full");
              });
            }),
            target.string() + "/a.txt: the disk is full");
  EXPECT_TRUE(fs::is_empty(folder_.path()));
  replace_folder(target, write_two);
  EXPECT_EQ(text_of(target / "sub/b.txt"), "b");
  replace_folder(target, write_two);  // its own files

  fs::create_directories(folder_ / "foreign/sub");
  write("foreign/sub/b.txt");
  EXPECT_THAT(error_of([&] { replace_folder(folder_ / "foreign", write_two); }),
              HasSubstr("sub/b.txt: exists already"));
  EXPECT_FALSE(fs::exists(folder_ / "foreign/a.txt"));
  EXPECT_EQ(text_of(folder_ / "foreign/sub/b.txt"), "somebody's");
  for (const auto& entry : fs::directory_iterator(folder_.path()))
    EXPECT_FALSE(entry.path().filename().string().starts_with('.')) << entry.path();
}

TEST_F(Guarded, a_new_folder_is_missing_or_empty) {
  EXPECT_EQ(error_of([&] { require_new_folder(folder_ / "missing", false); }), "");
  EXPECT_EQ(error_of([&] { require_new_folder(folder_.path(), false); }), "");
  write("file");
  EXPECT_EQ(error_of([&] { require_new_folder(folder_.path(), true); }), "");
  EXPECT_THAT(error_of([&] { require_new_folder(folder_.path(), false); }, ErrorKind::usage),
              HasSubstr("this folder exists already and is not empty"));
}

TEST_F(Guarded, a_guard_of_a_thread_holds_for_this_thread_alone) {
  write("file");
  const FileGuard of_process(true);
  std::thread([&] {
    const FileGuard of_thread(false, "the option overwrite", GuardScope::thread);
    EXPECT_FALSE(may_overwrite());
    EXPECT_THAT(error_of([&] { check_target(folder_ / "file"); }, ErrorKind::usage),
                testing::EndsWith("or replace it with the option overwrite"));
    std::thread([&] {
      EXPECT_TRUE(may_overwrite());
      EXPECT_TRUE(check_target(folder_ / "file"));
    }).join();
  }).join();
  EXPECT_TRUE(may_overwrite());
  const FileGuard of_thread(false, "x", GuardScope::thread);
  EXPECT_FALSE(may_overwrite());
}

}  // namespace
}  // namespace qs
