// SPDX-License-Identifier: MIT
//
// The preferences: their text, their file, and damaged files.
#include "app/viewer/preferences.h"

#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "io/camera/cameras.h"
#include "support/scenes.h"
#include "support/temporary_folder.h"

namespace qs {
namespace {

using testing::HasSubstr;
using testing::SizeIs;

TEST(Preferences, are_the_viewer_s_choices_and_the_views_of_its_scenes) {
  const TemporaryFolder folder;
  Viewer written;
  written.vsync = written.on_demand = written.reduce_when_moving = written.occlusion = false;
  written.panels.info = true;
  written.navigation = Navigation::fly;
  written.recent = {"/a.ply", "/b c.ply"};
  written.last_views["/a.ply"] = "kept";
  written.ups["/a.ply"] = "0,-1,0.5";
  written.axes["/a.ply"] = "RFU";
  written.first_views["/a.ply"] = "chosen";
  written.bookmarks["/a.ply RDF"] = {{"the door", "a camera"}};
  written.interface_scale = 1.5f;
  written.light_theme = true;
  written.scene.emplace();
  written.scene->path = "/b.ply";
  written.camera = test::front_camera(64, 48);
  write_preferences(folder / "deep/viewer.json", written, {1600, 900});
  Viewer read;
  glm::ivec2 size(0);
  EXPECT_EQ(read_preferences(folder / "deep/viewer.json", read, size), "");
  EXPECT_EQ(size, glm::ivec2(1600, 900));
  EXPECT_FALSE(read.vsync || read.on_demand || read.reduce_when_moving || read.occlusion);
  EXPECT_TRUE(read.panels.info);
  EXPECT_EQ(read.navigation, Navigation::fly);
  EXPECT_EQ(read.recent, written.recent);
  EXPECT_EQ(read.ups, written.ups);
  EXPECT_EQ(read.axes, written.axes);
  EXPECT_EQ(read.first_views, written.first_views);
  EXPECT_EQ(read.bookmarks, written.bookmarks);
  EXPECT_EQ(read.interface_scale, 1.5f);
  EXPECT_TRUE(read.light_theme);
  EXPECT_THAT(read.last_views,
              testing::ElementsAre(testing::Pair("/a.ply", "kept"),
                                   testing::Pair("/b.ply", format_camera(written.camera))));
}

TEST(Preferences, bookmarks_of_too_many_bytes_are_left_out_so_that_the_file_can_be_read) {
  Viewer written;
  written.bookmarks["/a.ply RDF"] = {{"short", "a camera"}};
  written.bookmarks["/b.ply RDF"] = {{"long", std::string(3 << 20, 'x')}, {"short", "a camera"}};
  Viewer read;
  glm::ivec2 size(0);
  parse_preferences(format_preferences(written, {640, 480}), read, size);
  EXPECT_EQ(read.bookmarks,
            (std::map<std::string, Bookmarks>{{"/a.ply RDF", {{"short", "a camera"}}}}));
}

TEST(Preferences, damaged_ones_are_reported_and_ignored) {
  const TemporaryFolder folder;
  for (const char* text : {"{", "[]", "{\"width\": \"wide\"}", "{\"vsync\": false, \"recent\": 3}",
                           "{\"width\": 7e51}", "{\"height\": 2147483648}"}) {
    std::ofstream(folder / "viewer.json") << text;
    Viewer viewer;
    glm::ivec2 size(1280, 720);
    EXPECT_THAT(read_preferences(folder / "viewer.json", viewer, size), HasSubstr("ignored"))
        << text;
    EXPECT_EQ(size, glm::ivec2(1280, 720));
    EXPECT_TRUE(viewer.vsync);
  }
  Viewer viewer;
  glm::ivec2 size(1280, 720);
  EXPECT_EQ(read_preferences(folder / "missing.json", viewer, size), "");
  std::ofstream(folder / "viewer.json") << "{\"width\": 3, \"height\": 99999}";
  EXPECT_EQ(read_preferences(folder / "viewer.json", viewer, size), "");
  EXPECT_EQ(size, glm::ivec2(320, 16384));
}

TEST(Preferences, the_scale_of_the_interface_is_within_its_limits) {
  const auto scale_of = [](const std::string& number) {
    Viewer viewer;
    glm::ivec2 size(1, 1);
    parse_preferences("{\"interface_scale\": " + number + "}", viewer, size);
    return viewer.interface_scale;
  };
  EXPECT_EQ(scale_of("0"), 0) << "not chosen";
  EXPECT_EQ(scale_of("0.75"), 0.75f);
  EXPECT_EQ(scale_of("3"), 3);
  EXPECT_EQ(scale_of("0.1"), 0.75f);
  EXPECT_EQ(scale_of("-1"), 0.75f);
  EXPECT_EQ(scale_of("99"), 3);
}

TEST(Preferences, are_written_into_the_current_folder_by_a_name_alone) {
  const TemporaryFolder folder;
  const std::filesystem::path before = std::filesystem::current_path();
  std::filesystem::current_path(folder.path());
  write_preferences("viewer.json", Viewer(), {640, 480});
  std::filesystem::current_path(before);
  EXPECT_TRUE(std::filesystem::exists(folder / "viewer.json"));
}

TEST(Preferences, a_window_s_size_and_a_hundred_views_are_kept) {
  const auto size_of = [](const char* text) {
    Viewer viewer;
    glm::ivec2 size(1, 1);
    parse_preferences(text, viewer, size);
    return size;
  };
  EXPECT_EQ(size_of(R"({"width": 320, "height": 240})"), glm::ivec2(320, 240));
  EXPECT_EQ(size_of(R"({"width": 319, "height": 239})"), glm::ivec2(320, 240));
  EXPECT_EQ(size_of(R"({"width": 16384, "height": 16384})"), glm::ivec2(16384));
  EXPECT_EQ(size_of(R"({"width": 16385, "height": 16385})"), glm::ivec2(16384));
  EXPECT_EQ(size_of("{}"), glm::ivec2(1)) << "the size is not chosen yet";
  Viewer viewer;
  for (int i = 1000; i < 1100; ++i) viewer.last_views[std::to_string(i)] = "x";
  const auto kept = [&] {
    Viewer read;
    glm::ivec2 size(0);
    parse_preferences(format_preferences(viewer, {640, 480}), read, size);
    return read.last_views;
  };
  EXPECT_THAT(kept(), SizeIs(100));
  viewer.last_views["2000"] = "x";
  EXPECT_THAT(kept(), SizeIs(100));
  EXPECT_FALSE(kept().contains("1000"));
  const TemporaryFolder folder;
  std::ofstream(folder / "big") << "";
  std::filesystem::resize_file(folder / "big", (4 << 20) + 1);
  glm::ivec2 size(0);
  EXPECT_THAT(read_preferences(folder / "big", viewer, size),
              HasSubstr("4194305 bytes are more than the 4194304 that are read"));
  write_preferences("", viewer, {1, 1});  // no file: nothing is kept
}

}  // namespace
}  // namespace qs
