// SPDX-License-Identifier: MIT
//
// JSON formats are told apart by the keys of their outermost object, not by words anywhere.
#include <string>

#include <gtest/gtest.h>

#include "io/bytes/json_text.h"

namespace qs {
namespace {

TEST(JsonKind, is_decided_by_the_outermost_keys) {
  EXPECT_EQ(json_kind(R"( [{"id": 0, "fx": 1}])"), JsonKind::cameras);
  EXPECT_EQ(json_kind("[]"), JsonKind::cameras);
  EXPECT_EQ(json_kind(R"([{"id": 0, "time" : 0.5}])"), JsonKind::camera_path);
  EXPECT_EQ(json_kind(R"({"camera_angle_x": 1, "frames": [{"time": 0.25}]})"),
            JsonKind::transforms);
  EXPECT_EQ(json_kind(R"({"means": {"files": []}, "quats": {}})"), JsonKind::sog);
  EXPECT_EQ(json_kind(R"({"tree": {"lods": {}}, "filenames": []})"), JsonKind::streamed_sog);
  EXPECT_EQ(json_kind(R"({"asset": {}, "meshes": []})"), JsonKind::gltf);
  EXPECT_EQ(json_kind(R"({"version": 1, "instances": [{}], "scene": ""})"), JsonKind::instances);
  EXPECT_EQ(json_kind(R"({"a": 1})"), JsonKind::other);
  EXPECT_EQ(json_kind("  "), JsonKind::none);
  EXPECT_EQ(json_kind("ply\n"), JsonKind::none);
}

TEST(JsonKind, nested_keys_values_and_later_entries_do_not_count) {
  EXPECT_EQ(json_kind(R"([{"exif": {"time": 3}}, {"time": 4}])"), JsonKind::cameras);
  EXPECT_EQ(json_kind(R"([{"id": "time"}])"), JsonKind::cameras);
  EXPECT_EQ(json_kind(R"([{"name": "a\", \"time\": 3"}])"), JsonKind::cameras);
  EXPECT_EQ(json_kind(R"([{"name": "a\\", "time": 3}])"), JsonKind::camera_path);
  EXPECT_EQ(json_kind(R"({"a": {"means": 1, "quats": 2}})"), JsonKind::other);
  EXPECT_EQ(json_kind(R"({"a": "frames"})"), JsonKind::other);
  EXPECT_EQ(json_kind(R"({"a": [[{"asset": 1}]], "meshes": []})"), JsonKind::other);
}

TEST(JsonKind, every_beginning_of_a_file_has_a_kind) {
  const std::string text = R"({"a": ["b\\\"", {}], "frames": [1]})";
  for (std::size_t length = 0; length <= text.size(); ++length) {
    const JsonKind kind = json_kind(std::string_view(text).substr(0, length));
    EXPECT_EQ(kind, length == 0                         ? JsonKind::none
                    : length <= text.find("frames") + 7 ? JsonKind::other
                                                        : JsonKind::transforms)
        << length;
  }
}

}  // namespace
}  // namespace qs
