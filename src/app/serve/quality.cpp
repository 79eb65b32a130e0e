// SPDX-License-Identifier: MIT
#include "app/serve/quality.h"

#include <algorithm>

#include "app/viewer/render/resolution.h"

namespace qs {

// The limits of the rates differ, so that a rate between them changes nothing.
constexpr double kVideoBelow = 60e6, kJpegAbove = 90e6;  ///< bits per second of the line
constexpr double kShare = 0.7;                           ///< of the line, for pictures
constexpr double kMostVideo = 8e6, kLeastVideo = 1e6;    ///< bits per second
constexpr double kJpegRate = 25;  ///< pictures per second that JPEG allows for
constexpr int kBestJpeg = 90, kWorstJpeg = 40, kEasyJpeg = 80;
constexpr int kEasyQuantizer = 28;  ///< four times the pixels stay below the coarsest quantiser
constexpr int kWorstPictures = 10;  ///< in a row, before the size shrinks
constexpr int kPatience = 30, kMostPatience = 480;  ///< pictures
constexpr int kShortJpeg = 300;  ///< pictures; a line that JPEG leaves sooner is at the limit
constexpr int kCodecPatience = 120, kMostCodecPatience = 7680;  ///< pictures
constexpr int kFailedGrowth = 90;  ///< pictures; a size that lasts no longer was too large

void Quality::decodes_video(bool decodes) {
  decodes_ = decodes;
  ++keys_;
}

// A line at the limit gets video, because each return to JPEG that does not last makes the next
// one later.
void Quality::choose_codec(const LineSpeed& line) {
  ++since_jpeg_;
  fast_ = line.at_least > kJpegAbove ? fast_ + 1 : 0;
  if (is_slow_ && fast_ > codec_patience_) {
    is_slow_ = false;
    since_jpeg_ = 0;
  } else if (!is_slow_ && line.at_most > 0 && line.at_most < kVideoBelow) {
    is_slow_ = true;
    const int longer = std::clamp(2 * codec_patience_, kCodecPatience, kMostCodecPatience);
    codec_patience_ = since_jpeg_ < kShortJpeg ? longer : 0;
  }
}

Encoding Quality::next(const LineSpeed& line) {
  line_rate_ = line.estimate;
  choose_codec(line);
  Encoding encoding;
  encoding.keys = keys_;
  encoding.quality = quality_;
  if (!has_vp9() || !decodes_ || !is_slow_) return encoding;
  encoding.codec = PictureCodec::vp9;
  encoding.bits_per_second =
      static_cast<int>(std::clamp(kShare * line.estimate, kLeastVideo, kMostVideo));
  return encoding;
}

void Quality::learn(const EncodedPicture& picture, int divisor) {
  if (divisor < divisor_) return;  // it was ordered before the size shrank
  ++since_growth_;
  if (picture.codec == PictureCodec::vp9)
    return choose_size(picture.quantizer >= kMostQuantizer, picture.quantizer <= kEasyQuantizer,
                       divisor);
  if (line_rate_ <= 0) return;
  const auto bytes = static_cast<double>(picture.bytes.size());
  const double budget = kShare * line_rate_ / 8 / kJpegRate;
  const bool is_large = bytes > budget;
  const double larger = static_cast<double>(divisor) / std::max(1, divisor - 1);
  choose_size(is_large && quality_ == kWorstJpeg,
              quality_ >= kEasyJpeg && bytes * larger * larger < budget, divisor);
  if (is_large) quality_ = std::max(kWorstJpeg, quality_ - 10);
  if (bytes < 0.7 * budget) quality_ = std::min(kBestJpeg, quality_ + 2);
}

void Quality::choose_size(bool is_worst, bool is_easy, int divisor) {
  worst_ = is_worst ? worst_ + 1 : 0;
  easy_ = is_easy ? easy_ + 1 : 0;
  if (worst_ >= kWorstPictures && divisor_ < kMostDivisor) {
    patience_ = since_growth_ < kFailedGrowth ? std::min(2 * patience_, kMostPatience) : kPatience;
    divisor_ = std::min(divisor + 1, kMostDivisor);
    worst_ = easy_ = 0;
  } else if (easy_ >= patience_ && divisor_ > 1) {
    --divisor_;
    worst_ = easy_ = since_growth_ = 0;
  }
}

}  // namespace qs
