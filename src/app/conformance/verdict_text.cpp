// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <cstdlib>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "app/conformance/judge.h"
#include "app/picture/canvas.h"
#include "app/picture/palette.h"
#include "app/report/html_page.h"
#include "base/json_of.h"
#include "base/list_of.h"
#include "base/text.h"
#include "io/bytes/json_text.h"

namespace qs {
namespace {

using Json = nlohmann::ordered_json;

Json names_json(const std::vector<MistakeSet>& causes) {
  const auto name_of = [](std::size_t mistake) { return mistakes()[mistake].name; };
  return list_of<Json>(causes, [&](const auto& cause) { return list_of<Json>(cause, name_of); });
}

std::string alternatives(const std::vector<MistakeSet>& causes) {
  std::string text;
  for (const MistakeSet& cause : causes) text += (text.empty() ? "" : " or ") + names_of(cause);
  return text;
}

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
Image sheet_of(const KitView& view, const SceneVerdict& verdict, const Picture8& picture) {
  constexpr int kPanel = 224;  // px, largest side of an enlarged picture
  constexpr int kGap = 16, kLine = 18, kBar = 14, kTicks = 34;
  const Picture8 truth = picture8(draw_with(view, {}));
  const int width = view.camera.width, height = view.camera.height;
  const int zoom = std::max(1, kPanel / std::max(width, height));
  const int panels = verdict.causes.empty() ? 3 : 4;
  const Font font(kLine);
  Image sheet = plain_picture(panels * (zoom * width + kGap) + kBar + kTicks,
                              zoom * height + kLine + kLine / 2, glm::vec3(1));
  int left = 0;
  // color(pixel) for every pixel.
  const auto draw_panel = [&](const char* title, const auto& color) {
    draw_text(sheet, font, {left, 0}, title, on_white::kInk);
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x)
        fill_rect(sheet, {left + zoom * x, kLine + zoom * y, zoom, zoom},
                  color(static_cast<std::size_t>(y * width + x)));
    left += zoom * width + kGap;
  };
  draw_panel("truth", [&](std::size_t pixel) { return color_at(truth, pixel); });
  draw_panel("this renderer", [&](std::size_t pixel) { return color_at(picture, pixel); });
  draw_panel("difference", [&](std::size_t pixel) { return difference_at(truth, picture, pixel); });
  const int bar = left - kGap / 2, length = zoom * height;
  for (int y = 0; y < length; ++y)
    fill_rect(sheet, {bar, kLine + y, kBar, 1},
              viridis(1 - (static_cast<float>(y) + 0.5f) / static_cast<float>(length)));
  for (const int tick : {0, kScaleEnd / 2, kScaleEnd})
    draw_text(sheet, font, {bar + kBar + 4, kLine + length - length * tick / kScaleEnd - kLine / 2},
              std::to_string(tick) + (tick == kScaleEnd ? "+" : ""), on_white::kInk);
  left += kBar + kTicks;
  if (!verdict.causes.empty()) {
    const Picture8 wrong = picture8(draw_with(view, verdict.causes.front()));
    draw_panel("with the mistakes", [&](std::size_t pixel) { return color_at(wrong, pixel); });
  }
  return sheet;
}

std::string outcome(const SceneVerdict& verdict) {
  if (!verdict.problem.empty()) return verdict.problem;
  if (verdict.result == Result::missing) return "there is no picture";
  return verdict.result == Result::passed ? "-" : causes_text(verdict);
}

}  // namespace

std::string causes_text(const SceneVerdict& verdict) {
  if (!verdict.causes.empty()) return alternatives(verdict.causes);
  std::string text = "no known mistake explains it";
  if (!verdict.closest.empty())
    text += fmt::format("; closest: {}, {} dB", names_of(verdict.closest),
                        decibels(verdict.closest_psnr));
  return text;
}

std::string cause_text(const KitVerdict& judgement) {
  const std::size_t failed = judgement.count(Result::failed);
  if (failed == 0) return "No scene fails.";
  if (judgement.causes.empty()) return "No known mistake explains the scenes that fail.";
  std::string text = fmt::format("Likely cause: {}.", alternatives(judgement.causes));
  for (const std::size_t mistake : judgement.causes.front())
    text +=
        fmt::format(" {}: the renderer {}.", mistakes()[mistake].name, mistakes()[mistake].what);
  text += fmt::format(" This explains {} of {} failed scenes.", judgement.explained, failed);
  return text;
}

std::string format_verdict(const KitVerdict& judgement) {
  std::string text;
  for (std::size_t i = 0; i < judgement.scenes.size(); ++i) {
    const SceneVerdict& verdict = judgement.scenes[i];
    text += fmt::format("{:20}{:9}", kit_scenes()[i].name,
                        kResultNames[static_cast<int>(verdict.result)]);
    if (!verdict.problem.empty()) {
      text += verdict.problem;
    } else if (verdict.result != Result::missing) {
      text += fmt::format("{:>6} dB, largest difference {}", decibels(verdict.fit.psnr),
                          verdict.fit.largest);
      if (verdict.result == Result::failed) text += ": " + causes_text(verdict);
    }
    while (text.back() == ' ') text.pop_back();
    text += "\n";
  }
  return text + fmt::format("{} scenes pass, {} fail, {} are missing\n{}\n",
                            judgement.count(Result::passed), judgement.count(Result::failed),
                            judgement.count(Result::missing), cause_text(judgement));
}

std::string verdict_json(const KitVerdict& judgement) {
  Json scenes = Json::array();
  for (std::size_t i = 0; i < judgement.scenes.size(); ++i) {
    const SceneVerdict& verdict = judgement.scenes[i];
    Json entry = {{"name", kit_scenes()[i].name},
                  {"result", kResultNames[static_cast<int>(verdict.result)]}};
    if (!verdict.problem.empty()) {
      entry["problem"] = verdict.problem;
    } else if (verdict.result != Result::missing) {
      entry["psnr"] = finite_or_null(verdict.fit.psnr);
      entry["largest_difference"] = verdict.fit.largest;
    }
    if (verdict.result == Result::failed) entry["causes"] = names_json(verdict.causes);
    if (!verdict.causes.empty()) entry["explained_psnr"] = finite_or_null(verdict.explained_psnr);
    if (!verdict.closest.empty()) {
      entry["closest"] = names_json({verdict.closest}).front();
      entry["closest_psnr"] = finite_or_null(verdict.closest_psnr);
    }
    scenes.push_back(entry);
  }
  return json_file_text(
      {{"tolerance", {{"largest_difference", kLargestDifference}, {"psnr", kLeastPsnr}}},
       {"passed", judgement.count(Result::passed)},
       {"failed", judgement.count(Result::failed)},
       {"missing", judgement.count(Result::missing)},
       {"causes", names_json(judgement.causes)},
       {"explained", judgement.explained},
       {"scenes", scenes}});
}

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
