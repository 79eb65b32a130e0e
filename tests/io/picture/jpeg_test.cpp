// SPDX-License-Identifier: MIT
// Reading JPEG without OpenImageIO, against ImageMagick's and OpenImageIO's decoders.
#include <fstream>
#include <iterator>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/error.h"
#include "io/picture/image_file.h"
#include "io/picture/picture_formats.h"
#include "support/error_of.h"
#include "support/temporary_folder.h"
#include "support/paths.h"

namespace qs {
namespace {

using testing::HasSubstr;

const std::filesystem::path kPictures =
    test::source_path("tests/data/pictures");

std::string bytes_of(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

class Jpeg : public testing::TestWithParam<const char*> {
 protected:
  std::filesystem::path file() const { return kPictures / (GetParam() + std::string(".jpg")); }
  // The error of reading these bytes, with paths relative to the folder.
  std::string error_of(const std::string& bytes) const {
    std::ofstream(folder_ / "picture.jpg", std::ios::binary) << bytes;
    return test::error_of([&] { read_image(folder_ / "picture.jpg"); }, folder_.path());
  }
  TemporaryFolder folder_;
};

TEST_P(Jpeg, has_the_pixels_that_imagemagick_decodes) {
  const Image image = read_image(file());
  const Image expected = read_image(kPictures / ("jpeg_" + std::string(GetParam()) + ".ppm"));
  ASSERT_EQ(image.width, expected.width);
  ASSERT_EQ(image.height, expected.height);
  EXPECT_EQ(image.channels, GetParam() == std::string("gray") ? 1 : 3);
  // Decoders may differ in the last bit.
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      for (int c = 0; c < image.channels; ++c)
        ASSERT_NEAR(255 * image.at(x, y, c), 255 * expected.at(x, y, c), 1.01) << x << ' ' << y;
    }
  }
}

TEST_P(Jpeg, has_the_pixels_that_openimageio_decodes) {
  Image expected;
  try {
    expected = read_with_module(file());
  } catch (const Error& error) {
    if (error.kind() == ErrorKind::device) GTEST_SKIP() << error.what();
    throw;
  }
  const Image image = read_image(file());
  ASSERT_EQ(image.channels, expected.channels);
  ASSERT_EQ(image.values.size(), expected.values.size());
  for (std::size_t i = 0; i < image.values.size(); ++i)
    ASSERT_NEAR(255 * image.values[i], 255 * expected.values[i], 1.01) << i;
}

TEST_P(Jpeg, every_truncation_is_an_error_that_names_the_file) {
  const std::string whole = bytes_of(file());
  for (std::size_t size = 0; size < whole.size(); ++size)
    ASSERT_THAT(error_of(whole.substr(0, size)), testing::StartsWith("picture.jpg: ")) << size;
  EXPECT_THAT(error_of(whole.substr(0, whole.size() - 2)),
              HasSubstr("damaged JPEG: Premature end"));
}

TEST_P(Jpeg, damaged_bytes_never_crash) {
  std::mt19937 random(3);
  const std::string whole = bytes_of(file());
  int errors = 0;
  for (int trial = 0; trial < 300; ++trial) {
    std::string damaged = whole;
    for (int i = 0; i < 3; ++i) damaged[random() % damaged.size()] = static_cast<char>(random());
    errors += error_of(damaged).starts_with("picture.jpg: ") ? 1 : 0;
  }
  EXPECT_GT(errors, 100);
}

INSTANTIATE_TEST_SUITE_P(Jpeg, Jpeg, testing::Values("gray", "subsampled", "progressive"),
                         [](const auto& row) { return std::string(row.param); });

TEST(JpegFile, ending_jpeg_in_any_case_is_read_too) {
  const TemporaryFolder folder;
  for (const char* name : {"a.jpeg", "b.JPG"}) {
    std::filesystem::copy_file(kPictures / "gray.jpg", folder / name);
    EXPECT_EQ(read_image(folder / name).width, 17) << name;
  }
}

TEST(JpegFile, cmyk_is_refused) {
  EXPECT_EQ(test::error_of([] { read_image(kPictures / "cmyk.jpg"); }, kPictures),
            "cmyk.jpg: a JPEG with CMYK colours, which are for printing: convert it to RGB");
}

TEST(JpegFile, size_that_the_bytes_cannot_hold_is_refused) {
  const TemporaryFolder folder;
  std::string bytes = bytes_of(kPictures / "gray.jpg");
  const std::size_t frame =
      bytes.find("\xff\xc0");  // then length 2, precision 1, height 2, width 2
  ASSERT_NE(frame, std::string::npos);
  bytes.replace(frame + 5, 4, "\x40\x01\x40\x01");
  std::ofstream(folder / "a.jpg", std::ios::binary) << bytes;
  EXPECT_EQ(test::error_of([&] { read_image(folder / "a.jpg"); }, folder.path()),
            "a.jpg: claims 16385 x 16385 pixels, which its 194 bytes cannot hold");
}

}  // namespace
}  // namespace qs
