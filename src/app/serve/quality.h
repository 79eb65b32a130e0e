// SPDX-License-Identifier: MIT
//
// Chooses codec, quality and size of a visitor's moving pictures, so that the line carries them
// without delay. It learns from the line's rate and from finished pictures; without clocks.
#pragma once

#include "app/serve/flow.h"
#include "app/serve/picture_encoder.h"

namespace qs {

class Quality {
 public:
  /// The page can or cannot decode VP9 from now on, beginning with a key picture.
  void decodes_video(bool decodes);

  /// The next moving picture.
  Encoding next(const LineSpeed& line);

  /// The next moving picture has 1/divisor of the pixels along each side.
  int divisor() const { return divisor_; }

  /// A finished moving picture that was reduced by `divisor`.
  void learn(const EncodedPicture& picture, int divisor);

 private:
  void choose_codec(const LineSpeed& line);
  // `is_worst`: the coarsest picture of this size. `is_easy`: the next larger size would do.
  void choose_size(bool is_worst, bool is_easy, int divisor);

  bool decodes_ = false, is_slow_ = false;
  std::uint32_t keys_ = 0;
  double line_rate_ = 0;
  int fast_ = 0;              // pictures in a row over a line for JPEG, while it is slow
  int codec_patience_ = 0;    // such pictures before JPEG begins
  int since_jpeg_ = 1000;     // pictures since then
  int quality_ = 90;          // of JPEG
  int divisor_ = 1;           // at least; a slow backend may need more
  int worst_ = 0, easy_ = 0;  // pictures in a row
  int patience_ = 30;         // easy pictures before the size grows
  int since_growth_ = 1000;   // pictures
};

}  // namespace qs
