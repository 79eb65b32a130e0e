// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cstdlib>

#include <fmt/format.h>

#include "app/conformance/verdict_text.h"
#include "app/picture/canvas.h"
#include "app/picture/palette.h"
#include "app/report/html_page.h"
#include "base/text.h"

namespace qs {
namespace {

constexpr int kPanel = 224;  // px, largest side of an enlarged picture
constexpr int kGap = 16, kLine = 18, kBar = 14, kTicks = 34;
constexpr int kScaleEnd = 32;  // differences of 8-bit values that the colour bar shows

glm::vec3 color_at(const Picture8& picture, std::size_t pixel) {
  return glm::vec3(picture[3 * pixel], picture[3 * pixel + 1], picture[3 * pixel + 2]) / 255.0f;
}

// The largest difference of the channels, as a colour.
glm::vec3 difference_at(const Picture8& a, const Picture8& b, std::size_t pixel) {
  int largest = 0;
  for (std::size_t c = 0; c < 3; ++c)
    largest = std::max(largest, std::abs(int{a[3 * pixel + c]} - int{b[3 * pixel + c]}));
  return viridis(static_cast<float>(largest) / kScaleEnd);
}

// Enlarged pictures in a row with their titles above them.
class Sheet {
 public:
  Sheet(const Camera& camera, int panels)
      : width_(camera.width),
        height_(camera.height),
        zoom_(std::max(1, kPanel / std::max(camera.width, camera.height))),
        font_(kLine) {
    image_ = Image(panels * (zoom_ * width_ + kGap) + kBar + kTicks,
                   zoom_ * height_ + kLine + kLine / 2, 3);
    fill_rect(image_, {0, 0, image_.width, image_.height}, glm::vec3(1));
  }

  // color(pixel) for every pixel.
  template <class Color>
  void panel(const char* title, const Color& color) {
    draw_text(image_, font_, {x_, 0}, title, on_white::kInk);
    for (int y = 0; y < height_; ++y) {
      for (int x = 0; x < width_; ++x) {
        const auto pixel = static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) +
                           static_cast<std::size_t>(x);
        fill_rect(image_, {x_ + zoom_ * x, kLine + zoom_ * y, zoom_, zoom_}, color(pixel));
      }
    }
    x_ += zoom_ * width_ + kGap;
  }

  void bar() {
    const int height = zoom_ * height_;
    x_ -= kGap / 2;
    for (int y = 0; y < height; ++y)
      fill_rect(image_, {x_, kLine + y, kBar, 1},
                viridis(1 - (static_cast<float>(y) + 0.5f) / static_cast<float>(height)));
    for (const int tick : {0, kScaleEnd / 2, kScaleEnd}) {
      const int y = kLine + height - height * tick / kScaleEnd;
      draw_text(image_, font_, {x_ + kBar + 4, y - kLine / 2},
                std::to_string(tick) + (tick == kScaleEnd ? "+" : ""), on_white::kInk);
    }
    x_ += kBar + kTicks + kGap / 2;
  }

  const Image& image() const { return image_; }

 private:
  int width_, height_, zoom_, x_ = 0;
  Font font_;
  Image image_;
};

Image sheet_of(const KitView& view, const SceneVerdict& verdict, const Picture8& picture) {
  const Picture8 truth = picture8(draw_with(view, {}));
  Sheet sheet(view.camera, verdict.causes.empty() ? 3 : 4);
  sheet.panel("truth", [&](std::size_t pixel) { return color_at(truth, pixel); });
  sheet.panel("this renderer", [&](std::size_t pixel) { return color_at(picture, pixel); });
  sheet.panel("difference",
              [&](std::size_t pixel) { return difference_at(truth, picture, pixel); });
  sheet.bar();
  if (!verdict.causes.empty()) {
    const Picture8 wrong = picture8(draw_with(view, verdict.causes.front()));
    sheet.panel("with the mistakes", [&](std::size_t pixel) { return color_at(wrong, pixel); });
  }
  return sheet.image();
}

std::string outcome(const SceneVerdict& verdict) {
  if (!verdict.problem.empty()) return verdict.problem;
  if (verdict.result == Result::missing) return "there is no picture";
  return verdict.result == Result::passed ? "-" : causes_text(verdict);
}

}  // namespace

std::string verdict_page(const KitVerdict& judgement, const Submission& submission,
                         const std::string& name) {
  HtmlPage page("Conformance of " + name);
  page.paragraph(fmt::format("{} scenes pass, {} fail, {} are missing. {}",
                             judgement.count(Result::passed), judgement.count(Result::failed),
                             judgement.count(Result::missing), cause_text(judgement)));
  page.paragraph(fmt::format(
      "A scene passes if no 8-bit value differs by more than {} from the truth, which is computed "
      "in double precision, and the PSNR is at least {} dB. A cause is named if a renderer with "
      "these mistakes draws the same picture within the same tolerance.",
      kLargestDifference, kLeastPsnr));
  std::vector<std::vector<std::string>> rows = {
      {"scene", "result", "PSNR (dB)", "largest difference", "likely cause"}};
  for (std::size_t i = 0; i < judgement.scenes.size(); ++i) {
    const SceneVerdict& verdict = judgement.scenes[i];
    const bool compared = verdict.result != Result::missing && verdict.problem.empty();
    rows.push_back({kit_scenes()[i].name, kResultNames[static_cast<int>(verdict.result)],
                    compared ? decibels(verdict.fit.psnr) : "-",
                    compared ? std::to_string(verdict.fit.largest) : "-", outcome(verdict)});
  }
  page.table(rows);
  for (const Result result : {Result::failed, Result::passed}) {
    if (judgement.count(result) == 0) continue;
    page.heading(result == Result::failed ? "Scenes that fail" : "Scenes that pass");
    page.paragraph(fmt::format(
        "The difference is the largest of the three channels, of 255. {} and more have the last "
        "colour.",
        kScaleEnd));
    for (std::size_t i = 0; i < judgement.scenes.size(); ++i) {
      const SceneVerdict& verdict = judgement.scenes[i];
      if (verdict.result != result || submission.pictures[i].empty()) continue;
      const KitScene& scene = kit_scenes()[i];
      std::string caption = fmt::format("{}: {}.", scene.name, scene.what);
      if (result == Result::failed)
        caption +=
            (verdict.causes.empty() ? " Cause: " : " Likely cause: ") + causes_text(verdict) + ".";
      page.picture(sheet_of(scene.make(), verdict, submission.pictures[i]), caption);
    }
  }
  return page.text();
}

}  // namespace qs
