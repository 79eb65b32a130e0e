// SPDX-License-Identifier: MIT
//
// The codecs of a visitor's pictures, one picture after the other.
#include "app/serve/picture_encoder.h"

#include <gtest/gtest.h>

#include "base/progress.h"
#include "io/picture/webp_image.h"

namespace qs {
namespace {

class ServeEncoder : public testing::Test {
 protected:
  PictureEncoder encoder_;
  double now_ = 50;

  EncodedPicture encode(const Encoding& encoding, int width = 64, int height = 48) {
    const std::vector<std::uint8_t> rgba(4 * static_cast<std::size_t>(width * height), 99);
    now_ += 0.03;
    return encoder_.encode({rgba, width, height}, encoding, now_, {});
  }
  static Encoding video(std::uint32_t keys = 0) { return {PictureCodec::vp9, 90, 2'000'000, keys}; }
};

TEST_F(ServeEncoder, keys_come_first_when_asked_for_and_with_another_size) {
  if (!has_vp9()) GTEST_SKIP() << "needs libvpx";
  EXPECT_TRUE(encode(video()).is_key);
  EXPECT_FALSE(encode(video()).is_key);
  EXPECT_TRUE(encode(video(1)).is_key);
  EXPECT_FALSE(encode(video(1)).is_key);
  EXPECT_TRUE(encode(video(1), 32, 24).is_key);
  EXPECT_FALSE(encode(video(1), 32, 24).is_key);
}

TEST_F(ServeEncoder, a_change_of_codec_brings_a_key_and_a_picture_at_rest_does_not) {
  if (!has_vp9()) GTEST_SKIP() << "needs libvpx";
  encode(video());
  EXPECT_EQ(encode({PictureCodec::webp}).codec, PictureCodec::webp);
  EXPECT_FALSE(encode(video()).is_key);
  EXPECT_EQ(encode({PictureCodec::jpeg}).codec, PictureCodec::jpeg);
  EXPECT_TRUE(encode(video()).is_key);
}

TEST_F(ServeEncoder, a_failure_of_video_ends_in_jpeg) {
  // libvpx has no pictures of this width.
  const EncodedPicture picture = encode(video(), 16'385, 1);
  EXPECT_EQ(picture.codec, PictureCodec::jpeg);
  EXPECT_FALSE(picture.bytes.empty());
  EXPECT_EQ(encode(video()).codec, PictureCodec::jpeg) << "it is not tried again";
}

TEST_F(ServeEncoder, visitors_share_the_threads_of_video) {
  EXPECT_EQ(video_threads(16, 1), 4);
  EXPECT_EQ(video_threads(16, 4), 4);
  EXPECT_EQ(video_threads(16, 5), 3);
  EXPECT_EQ(video_threads(16, 9), 1);
  EXPECT_EQ(video_threads(16, 20), 1);
  EXPECT_EQ(video_threads(2, 1), 2);
  EXPECT_EQ(video_threads(2, 2), 1);
  EXPECT_EQ(video_threads(1, 0), 1);
}

TEST_F(ServeEncoder, a_video_goes_on_when_other_visitors_come) {
  if (!has_vp9()) GTEST_SKIP() << "needs libvpx";
  Encoding encoding = video();
  for (const int threads : {4, 1, 2}) {
    encoding.threads = threads;
    EXPECT_EQ(encode(encoding, 1024, 64).is_key, threads == 4);
  }
}

TEST_F(ServeEncoder, a_stop_ends_a_picture_at_rest) {
  std::stop_source stop;
  stop.request_stop();
  const std::vector<std::uint8_t> rgba(4 * 64 * 48);
  EXPECT_THROW(encoder_.encode({rgba, 64, 48}, {PictureCodec::webp}, 0, stop.get_token()),
               Cancelled);
}

}  // namespace
}  // namespace qs
