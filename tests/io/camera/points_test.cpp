// SPDX-License-Identifier: MIT
// COLMAP's points, written as text and binary, and read back.
#include <cmath>
#include <cstring>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "io/camera/cameras.h"
#include "support/error_of.h"
#include "support/shared.h"
#include "support/temporary_folder.h"

namespace qs {
namespace {

using test::error_of;
using testing::HasSubstr;

template <class T>
void put_bytes(std::string& bytes, T value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

// Two points; the second was seen in two images.
std::string binary_points(double x = 0.25) {
  std::string bytes;
  put_bytes<std::uint64_t>(bytes, 2);
  for (int i = 0; i < 2; ++i) {
    put_bytes<std::uint64_t>(bytes, 17);
    for (const double value : {x, -2.5, 3.0 + i}) put_bytes(bytes, value);
    for (const int value : {0, 51, 255}) put_bytes(bytes, static_cast<std::uint8_t>(value));
    put_bytes(bytes, 0.7);
    put_bytes<std::uint64_t>(bytes, static_cast<std::uint64_t>(2 * i));
    bytes.append(static_cast<std::size_t>(16 * i), 'x');
  }
  return bytes;
}

class Points : public testing::Test {
 protected:
  std::filesystem::path write(const std::filesystem::path& name, const std::string& content) {
    const auto path = folder_ / name;
    std::filesystem::create_directories(path.parent_path());
    std::ofstream(path, std::ios::binary) << content;
    return path;
  }
  std::string error_in(const std::filesystem::path& file) {
    return error_of([&] { read_points(file, warnings_); }, folder_.path());
  }

  std::vector<std::string> warnings_;

  TemporaryFolder folder_;
};

TEST_F(Points, text_and_binary_are_the_same_points) {
  const auto text = write("points3D.txt",
                          "# a comment\n\n17 0.25 -2.5 3 0 51 255 0.7\n"
                          "17 0.25 -2.5 4 0 51 255 0.7 1 2 3 4\n");
  for (const auto& file : {text, write("points3D.bin", binary_points())}) {
    const auto points = read_points(file, warnings_);
    ASSERT_EQ(points.size(), 2u) << file;
    EXPECT_EQ(points[0].position, glm::dvec3(0.25, -2.5, 3));
    EXPECT_EQ(points[1].position, glm::dvec3(0.25, -2.5, 4));
    EXPECT_EQ(points[1].color, glm::vec3(0, 0.2f, 1));
  }
}

TEST_F(Points, are_found_in_the_folders_of_a_data_set) {
  const auto found = [&](const char* model) {
    return find_points_file(folder_ / model, folder_.path());
  };
  EXPECT_EQ(found("sparse/0"), std::nullopt);
  const auto beside = write("points3D.txt", "");
  for (const char* model : {"", "sparse", "sparse/0"}) EXPECT_EQ(found(model), beside) << model;
  const auto inside = write("sparse/0/points3D.bin", binary_points());
  EXPECT_EQ(found("sparse/0"), inside);
  EXPECT_EQ(found("sparse"), beside);
}

TEST_F(Points, damage_is_named_with_file_and_record) {
  EXPECT_EQ(error_in(write("points3D.bin", binary_points(NAN))), "");
  EXPECT_THAT(warnings_, testing::ElementsAre(HasSubstr("points3D.bin: 2 of 2 points left out")));
  EXPECT_THAT(error_in(write("points3D.txt", "1 2 3\n")),
              HasSubstr("points3D.txt: line 1: the position is missing"));
  EXPECT_THAT(error_in(write("points3D.txt", "1 2 3 4 5 6 256\n")),
              HasSubstr("points3D.txt: line 1: the colour '256' is not a number"));
  EXPECT_THAT(error_in(folder_ / "missing.bin"), HasSubstr("missing.bin"));
}

TEST_F(Points, binary_that_is_cut_off_anywhere_is_an_error) {
  const std::string whole = binary_points();
  for (std::size_t size = 0; size < whole.size(); ++size)
    EXPECT_THAT(error_in(write("points3D.bin", whole.substr(0, size))), HasSubstr("cut off"));
}

TEST_F(Points, binary_with_more_bytes_than_its_records_is_an_error) {
  EXPECT_THAT(error_in(write("points3D.bin", binary_points() + "xyz")),
              HasSubstr("points3D.bin: 3 bytes follow the 2 points that it announces"));
}

TEST(PointsOfAScene, of_the_training_photographs_are_read) {
  QS_NEEDS_SHARED("scenes/plush_train");
  const auto data = test::shared_path("scenes/plush_train");
  const auto file = find_points_file(data / "sparse/0", data);
  ASSERT_TRUE(file);
  std::vector<std::string> warnings;
  EXPECT_EQ(read_points(*file, warnings).size(), 25'784u);
  EXPECT_TRUE(warnings.empty());
}

}  // namespace
}  // namespace qs
