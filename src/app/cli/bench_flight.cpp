// SPDX-License-Identifier: MIT
#include "app/cli/bench_flight.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdlib>
#include <mutex>
#include <thread>

#include <fmt/format.h>

#include "app/measure/camera_path.h"
#include "app/measure/scene_facts.h"
#include "app/measure/statistics.h"
#include "app/report/environment.h"
#include "app/session/alterations.h"
#include "app/session/levels.h"
#include "base/progress_bar.h"
#include "base/seconds.h"
#include "base/text.h"
#include "io/bytes/json_text.h"
#include "io/bytes/replace_file.h"
#include "raster/scene/image.h"

namespace qs {
namespace {

using Clock = std::chrono::steady_clock;
using Json = nlohmann::ordered_json;

constexpr std::chrono::duration<double> kFrame{1.0 / 60};
constexpr double kLongestStay = 5;  // seconds at a place to which the camera jumped
constexpr double kLongestOpening = 30;
constexpr std::size_t kMostJumps = 8;
constexpr std::size_t kPictures = 24;  // of a flight, which are compared
constexpr int kSeenStep = 8;           // levels of 8 bits

struct FlightPace {
  const char* name;
  double speed;  // times the speed of the path; 0: jumps to up to kMostJumps of its keyframes
};
constexpr FlightPace kPaces[] = {{"walk", 1}, {"drive", 10}, {"jump", 0}};

// The percentage of pixels with a value that differs by kSeenStep or more.
double changed_percent(const Image& a, const Image& b) {
  const auto differs = [&](std::size_t i) {
    return std::abs(to_8bit(a.values[i]) - to_8bit(b.values[i])) >= kSeenStep;
  };
  double pixels = 0;
  for (std::size_t i = 0; i < a.values.size(); i += 3)
    pixels += differs(i) || differs(i + 1) || differs(i + 2) ? 1 : 0;
  return 300 * pixels / static_cast<double>(a.values.size());
}

// The median and the 99th percentile; null without values.
Json both(const std::vector<double>& values) {
  if (values.empty()) return nullptr;
  return {{"p50", median(values)}, {"p99", percentile(values, 0.99)}};
}

// The session was just opened.
Json fly(Session& session, const std::vector<Keyframe>& path, const FlightPace& pace,
         const Progress& progress) {
  const std::shared_ptr<PageStream> stream = session.scene->stream;
  std::mutex mutex;  // of the next two
  LevelFacts last;
  std::vector<double> cut_ms;
  const auto note = [&](const LevelFacts& facts) {
    for (const std::string& sentence : facts.sentences) warn("warning: " + sentence);
    const std::lock_guard lock(mutex);
    last = facts;
    cut_ms.push_back(facts.ms);
  };
  std::atomic<bool> awaits = false;
  session.renderer.reset();
  auto own = make_renderer(session.backend, *session.pool, session.device);
  Renderer& inner = *own;  // draws the last cut
  const auto renderer = with_levels(std::move(own), session.levels, *session.pool, note, &awaits);
  expect_stream(*renderer, stream);
  renderer->upload(cloud_of(session.scene), {});
  // The picture of the view's own cut, which is not measured.
  const auto exact = [&](const Camera& camera) -> const Frame& {
    awaits = true;
    const Frame& frame = renderer->render(camera, session.settings);
    awaits = false;
    return frame;
  };
  std::vector<double> frame_ms, whole_ms, sharp_s, pops, behind;
  std::size_t incomplete = 0;
  std::vector<std::pair<Camera, Image>> kept;
  Clock::time_point start = Clock::now(), next = start;
  double paused = 0;  // seconds of pictures that a flight does not have
  // Draws a frame when a display would show it. True if it has all pages of its view.
  const auto draw = [&](const Camera& camera, bool keeps) {
    std::this_thread::sleep_until(next);
    const Clock::time_point came = Clock::now();
    Image before;
    if (keeps && pace.speed > 0) before = inner.render(camera, session.settings).color;
    const std::chrono::duration<double> pause = Clock::now() - came;
    paused += pause.count();
    next =
        std::max(next + std::chrono::duration_cast<Clock::duration>(kFrame + pause), Clock::now());
    std::unique_lock lock(mutex);
    const bool is_sharp = !stream || (last.drawn > 0 && last.missing == 0 &&
                                      last.camera.view_from_world == camera.view_from_world);
    incomplete += last.missing > 0 ? 1 : 0;
    lock.unlock();
    const bool on_host = keeps || session.backend == Backend::cpu;
    const Target target = on_host ? Target(HostImage{}) : Target(DeviceImage{});
    const Clock::time_point begin = Clock::now();
    const Frame& frame = renderer->render(camera, session.settings, {}, target, progress.stop);
    whole_ms.push_back(milliseconds_since(begin));
    frame_ms.push_back(static_cast<double>(frame.stats.frame_ms));
    if (keeps) kept.emplace_back(camera, frame.color);
    if (!before.values.empty()) pops.push_back(changed_percent(before, frame.color));
    return is_sharp;
  };
  const auto stay = [&](const Camera& camera, double longest) {
    const Clock::time_point came = Clock::now();
    while (!draw(camera, false) && seconds_since(came) < longest) {
    }
    return seconds_since(came);
  };
  if (pace.speed > 0) {
    stay(path.front().camera, kLongestOpening);
    const std::lock_guard lock(mutex);
    for (auto* const values : {&frame_ms, &whole_ms, &cut_ms}) values->clear();
    incomplete = 0;
    paused = 0;
    start = next = Clock::now();
  }
  const StreamFacts before = stream ? stream->facts() : StreamFacts();
  const double first = path.front().time, whole = path.back().time - first;
  for (double t = 0; pace.speed > 0 && t < whole;
       t = (seconds_since(start) - paused) * pace.speed) {
    draw(camera_at(path, first + t), t * kPictures >= whole * static_cast<double>(kept.size()));
    progress.update(static_cast<float>(t / whole));
  }
  const std::size_t stops = std::min(path.size(), kMostJumps);
  for (std::size_t i = 0; pace.speed == 0 && i < stops; ++i) {
    const Camera camera = camera_at(path, path[i * (path.size() - 1) / (stops - 1)].time);
    sharp_s.push_back(stay(camera, kLongestStay));
    draw(camera, true);
    progress.update(static_cast<float>(i + 1) / static_cast<float>(stops));
  }
  const double seconds = seconds_since(start) - paused;
  const StreamFacts after = stream ? stream->facts() : StreamFacts();
  std::unique_lock lock(mutex);
  const Json cuts = both(cut_ms);
  lock.unlock();
  for (const auto& [camera, picture] : kept)
    behind.push_back(changed_percent(picture, exact(camera).color));
  return {{"pace", pace.name},
          {"seconds", seconds},
          {"frames", frame_ms.size()},
          {"frame_ms", both(frame_ms)},
          {"with_uploads_ms", both(whole_ms)},
          {"cut_ms", cuts},
          {"frames_with_missing_pages", incomplete},
          {"popping_percent", both(pops)},
          {"behind_percent", both(behind)},
          {"sharp_after_s", both(sharp_s)},
          {"pages_read", after.read - before.read},
          {"megabytes_read", static_cast<double>(after.read_bytes - before.read_bytes) / 1e6}};
}

std::string text_of(const Json& value) {
  if (value.is_null()) return "-";
  if (value.is_object()) return text_of(value["p50"]) + " / " + text_of(value["p99"]);
  if (value.is_number_float()) return three_digits(value);
  return value.is_string() ? value.get<std::string>() : grouped(value);
}

// A row per flight and a column per member.
std::string table_of(const Json& flights) {
  std::string head = "|", rule = "|", rows;
  for (const auto& [name, value] : flights[0].items()) {
    std::string words = name;
    std::ranges::replace(words, '_', ' ');
    head += " " + words + " |";
    rule += value.is_string() ? "---|" : "---:|";
  }
  for (const Json& flight : flights) {
    rows += "|";
    for (const Json& value : flight) rows += " " + text_of(value) + " |";
    rows += "\n";
  }
  return head + "\n" + rule + "\n" + rows;
}

}  // namespace

void bench_flight(const FrameOptions& frame, const std::filesystem::path& path,
                  const std::optional<std::filesystem::path>& out_dir) {
  std::vector<Keyframe> keyframes = read_camera_path(path);
  for (Keyframe& keyframe : keyframes)
    if (frame.size) keyframe.camera = keyframe.camera.resized(frame.size->x, frame.size->y);
  Json json;
  std::string text;
  for (const FlightPace& pace : kPaces) {
    Session session = open_session(frame);
    for (Keyframe& keyframe : keyframes)
      keyframe.camera = keyframe.camera.placed(session.scene->cloud.origin);
    if (json.is_null()) {
      const Camera& camera = keyframes.front().camera;
      json = {{"written_by", "quadsplat"},
              {"environment", environment_json(session)},
              {"scene", scene_json(session)},
              {"path", path.string()}};
      text =
          fmt::format("# Flight: {}, {} x {}, backend {}{}\n\n",
                      markdown_text(scene_name(session.scene->path)), camera.width, camera.height,
                      kBackendNames[static_cast<int>(session.backend)], altered_clause(session));
    }
    ProgressBar bar(fmt::format("flying ({})", pace.name));
    json["flights"].push_back(fly(session, keyframes, pace, bar.progress()));
  }
  text += table_of(json["flights"]) +
          "\nPairs are the median and the 99th percentile. Pixels count that differ by 8 of 255 "
          "levels or more. Popping: from the same view with the cut of the frame before. Behind: "
          "from the picture of the view's own cut.\n";
  fmt::print("{}", text);
  if (!out_dir) return;
  replace_folder(*out_dir, [&](const std::filesystem::path& hidden) {
    write_text(hidden / "flight.json", json_file_text(json));
    write_text(hidden / "flight.md", "<!-- written by quadsplat bench -->\n" + text);
  });
  fmt::print(stderr, "wrote {}\n", out_dir->string());
}

}  // namespace qs
