// SPDX-License-Identifier: MIT
// Files of pictures, as the program reads and writes them.
#include <fstream>

#include "app/support/run_program.h"
#include "io/picture/image_file.h"
#include "library/opened_scene.h"
#include "support/temporary_folder.h"

namespace qs {
namespace {

class LibraryPictures : public testing::Test {
 protected:
  std::string path(const std::string& name) const { return (folder_ / name).string(); }
  std::string error_of_saving(const QsArray& values, const std::string& name,
                              std::uint32_t overwrite = 0, std::int32_t code = QS_USAGE) const {
    return test::sentence_of(
        [&] { quadsplat::check(qs_picture_save, &values, path(name).c_str(), overwrite); }, code);
  }

  TemporaryFolder folder_;
};

TEST_F(LibraryPictures, hold_the_values_in_any_layout) {
  constexpr int kHeight = 3, kWidth = 5;
  std::vector<float> planes(kHeight * kWidth * 3);
  for (std::size_t i = 0; i < planes.size(); ++i) planes[i] = static_cast<float>(i) / 7 - 1;
  const QsArray values = quadsplat::planes_of(planes.data(), kHeight, kWidth);
  ASSERT_EQ(error_of_saving(values, "a.npy"), "");
  const Image image = read_image(path("a.npy"));
  ASSERT_EQ(image.width, kWidth);
  ASSERT_EQ(image.height, kHeight);
  ASSERT_EQ(image.channels, 3);
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x)
      for (int c = 0; c < 3; ++c)
        EXPECT_EQ(image.at(x, y, c),
                  planes[static_cast<std::size_t>((c * kHeight + y) * kWidth + x)]);

  QsPictureFile* picture = nullptr;
  QsArray read{};
  quadsplat::check(qs_picture_open, path("a.npy").c_str(), &picture, &read);
  EXPECT_EQ(read.dimensions, 3u);
  EXPECT_EQ(std::vector<std::int64_t>(read.sizes, read.sizes + 3),
            (std::vector<std::int64_t>{kHeight, kWidth, 3}));
  EXPECT_EQ(std::vector<std::int64_t>(read.strides, read.strides + 3),
            (std::vector<std::int64_t>{kWidth * 3, 3, 1}));
  const auto* found = static_cast<const float*>(read.data);
  EXPECT_EQ(std::vector<float>(found, found + planes.size()), image.values);
  qs_picture_close(picture);
  qs_picture_close(nullptr);
}

TEST_F(LibraryPictures, of_8_bits_keep_their_bytes) {
  std::vector<std::uint8_t> bytes(256);
  for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<std::uint8_t>(i);
  for (const QsArray& values : {quadsplat::array_of(bytes.data(), {16, 16}),
                                quadsplat::array_of(bytes.data(), {8, 8, 4})}) {
    ASSERT_EQ(error_of_saving(values, "a.png", 1), "");
    const Image image = read_image(path("a.png"));
    EXPECT_EQ(image.channels, values.dimensions == 2 ? 1 : 4);
    ASSERT_EQ(image.values.size(), bytes.size());
    for (std::size_t i = 0; i < bytes.size(); ++i) EXPECT_EQ(to_8bit(image.values[i]), bytes[i]);
  }
}

TEST_F(LibraryPictures, replace_pictures_of_the_program_alone) {
  std::vector<float> one(3, 0.5f);
  const QsArray values = quadsplat::array_of(one.data(), {1, 1, 3});
  EXPECT_EQ(error_of_saving(values, "a.png"), "");
  EXPECT_EQ(error_of_saving(values, "a.png"), "");
  std::ofstream(folder_ / "b.png") << "of the user";
  EXPECT_NE(error_of_saving(values, "b.png"), "");
  EXPECT_EQ(test::content_of(path("b.png")), "of the user");
  EXPECT_EQ(error_of_saving(values, "b.png", 1), "");
  EXPECT_EQ(read_image(path("b.png")).width, 1);
}

TEST_F(LibraryPictures, that_are_wrong_are_refused_in_a_sentence) {
  std::vector<float> some(30);
  const auto save = [&](std::initializer_list<std::int64_t> sizes) {
    return error_of_saving(quadsplat::array_of(some.data(), sizes), "a.npy");
  };
  EXPECT_EQ(save({0, 4, 3}),
            "qs_picture_save: values: 4 x 0 pixels are not between 1 x 1 and 65535 x 65535");
  EXPECT_EQ(save({65536, 1}),
            "qs_picture_save: values: 1 x 65536 pixels are not between 1 x 1 and 65535 x 65535");
  EXPECT_EQ(save({1, 6, 5}), "qs_picture_save: values: 5 channels are not between 1 and 4");
  EXPECT_EQ(save({30}), "qs_picture_save: values: has 1 dimensions instead of 3");
  EXPECT_EQ(save({}), "qs_picture_save: values: is absent: it needs 3 dimensions");
  QsArray wrong = quadsplat::array_of(some.data(), {2, 5, 3});
  EXPECT_EQ(error_of_saving(wrong, "a"),
            path("a") + ": the name needs an ending such as .png that tells the format");
  EXPECT_EQ(error_of_saving(wrong, "a.npy", 2), "qs_picture_save: overwrite: is 2");
  wrong.type = QS_INT32;
  EXPECT_EQ(error_of_saving(wrong, "a.npy"),
            "qs_picture_save: values: has elements of type int32 instead of float32 or uint8");
  EXPECT_TRUE(std::filesystem::is_empty(folder_ / "."));

  char message[QS_MESSAGE_BYTES];
  QsPictureFile* picture = nullptr;
  QsArray values{};
  EXPECT_EQ(qs_picture_save(nullptr, "a.png", 0, message), QS_USAGE);
  EXPECT_STREQ(message, "qs_picture_save: values: is null");
  EXPECT_EQ(qs_picture_save(&values, nullptr, 0, message), QS_USAGE);
  EXPECT_STREQ(message, "qs_picture_save: path: is null");
  EXPECT_EQ(qs_picture_open(nullptr, &picture, &values, message), QS_USAGE);
  EXPECT_STREQ(message, "qs_picture_open: path: is null");
  EXPECT_EQ(qs_picture_open("a.png", nullptr, &values, message), QS_USAGE);
  EXPECT_STREQ(message, "qs_picture_open: picture: is null");
  EXPECT_EQ(qs_picture_open("a.png", &picture, nullptr, message), QS_USAGE);
  EXPECT_STREQ(message, "qs_picture_open: values: is null");
  EXPECT_EQ(qs_picture_open(path("none.png").c_str(), &picture, &values, message), QS_INPUT);
  EXPECT_EQ(message, path("none.png") + ": no such file");
  EXPECT_EQ(picture, nullptr);
}

}  // namespace
}  // namespace qs
