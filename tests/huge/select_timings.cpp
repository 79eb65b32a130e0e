// SPDX-License-Identifier: MIT
//
// Times and memory of selecting and editing a city in memory, on the CPU:
//   select_timings [GAUSSIANS [VIEW]]        VIEW: 0 to 3, of City::cameras(), at 1600 x 1200
// docs/performance.md has results.
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <string>
#include <thread>

#include <fmt/format.h>

#include "base/text.h"
#include "huge/city.h"
#include "io/cloud/edits.h"
#include "io/edits/edits_file.h"
#include "raster/select/by_shape.h"
#include "raster/select/edit_history.h"

namespace qs {
namespace {

constexpr int kRounds = 5;

double ms_of(const auto& work) {
  const auto begin = std::chrono::steady_clock::now();
  work();
  const std::chrono::duration<double, std::milli> time = std::chrono::steady_clock::now() - begin;
  return time.count();
}

// The least time of some rounds, because other programs only lengthen a round.
void measure(const char* name, const auto& work) {
  double least = 1e9;
  for (int round = 0; round < kRounds; ++round) least = std::min(least, ms_of(work));
  fmt::print("{:<44} {:8.1f} ms\n", name, least);
  std::fflush(stdout);
}

double resident_mb() {
  std::ifstream status("/proc/self/status");
  std::string word;
  while (status >> word)
    if (word == "VmRSS:") break;
  double kilobytes = 0;
  status >> kilobytes;
  return kilobytes / 1024;
}

std::vector<glm::dvec2> lasso(glm::dvec2 center, double radius, int corners) {
  std::vector<glm::dvec2> points;
  for (int i = 0; i < corners; ++i) {
    const double angle = 6.283185307 * i / corners, wave = 1 + 0.2 * std::sin(7 * angle);
    points.push_back(center + radius * wave * glm::dvec2(std::cos(angle), std::sin(angle)));
  }
  return points;
}

void run(std::size_t count, std::size_t view) {
  ThreadPool pool(static_cast<int>(std::thread::hardware_concurrency()));
  const City city(count, 0, 1);
  const auto cloud = std::make_shared<const GaussianCloud>(city.part(0, count, pool));
  const Camera camera = city.cameras().at(view).resized(1600, 1200);
  const auto renderer = make_renderer(Backend::cpu, pool);
  renderer->upload(cloud, {});
  renderer->render(camera);
  const double before = resident_mb();
  fmt::print("{} Gaussians, view {}, {} threads, {:.0f} MB\n", grouped(count), view, pool.size(),
             before);

  measure("a frame", [&] { renderer->render(camera); });
  const auto seen = [&](const Shape& shape, float weight) {
    return seen_by(*renderer, *cloud, camera, shape, weight, pool, {});
  };
  const Shape all = Shape::rectangle({-1, -1}, {1600, 1200});
  const Shape part = Shape::rectangle({300, 200}, {1300, 1000});
  measure("visible: the whole picture", [&] { seen(all, kSelectWeight); });
  measure("visible: rectangle of 1000 x 800", [&] { seen(part, kSelectWeight); });
  measure("touching: the whole picture", [&] { seen(all, 0); });
  const std::vector<glm::dvec2> stroke = {{800, 600}, {840, 620}};
  measure("visible: brush of 40 px", [&] { seen(Shape::stroke(stroke, 40), kSelectWeight); });
  const Camera small = camera.resized(400, 300);
  const std::vector<glm::dvec2> small_stroke = {{200, 150}, {210, 155}};
  measure("visible: brush of 10 px, 400 x 300", [&] {
    seen_by(*renderer, *cloud, small, Shape::stroke(small_stroke, 10), kSelectWeight, pool, {});
  });
  measure("through: rectangle", [&] { gaussians_through(*cloud, camera, part, pool); });
  const Shape round = Shape::polygon(lasso({800, 600}, 400, 400));
  measure("through: lasso of 400 corners", [&] { gaussians_through(*cloud, camera, round, pool); });
  Outputs outputs;
  outputs.share = std::make_shared<const GaussianSet>(seen(part, kSelectWeight));
  measure("a frame and its tint", [&] { renderer->render(camera, {}, outputs); });

  // A session of the window: strokes, hiding half, undoing and redoing.
  const EditTools tools{*cloud, pool, seen_with(*renderer, cloud, pool, true), set_hash};
  EditHistory history(count);
  const auto step = [&](EditStep edit) {
    EditState state = history.state();
    carry_out(edit, tools, "step", state);
    if (edit.kind == EditKind::select) note_result(state, set_hash, edit.select);
    history.take(std::move(edit), std::move(state));
  };
  const auto show = [&] { renderer->set_drawn(history.state().rest()); };
  const auto select = [&](SelectTool tool, SelectHow how, std::vector<glm::dvec2> pixels) {
    step({.select = {.tool = tool,
                     .how = how,
                     .camera = camera,
                     .pixels = std::move(pixels),
                     .radius = 40}});
  };
  for (int i = 0; i < 20; ++i)
    select(SelectTool::brush, SelectHow::add, {{300 + 50 * i, 400}, {340 + 50 * i, 800}});
  fmt::print("{:<44} {:8.1f} MB more, {:.1f} MB of history\n", "20 strokes of a brush",
             resident_mb() - before, static_cast<double>(history.memory()) / 1e6);
  EditsFile file;
  file.steps = history.steps();
  fmt::print("{:<44} {:8.1f} MB\n", "their file",
             static_cast<double>(format_edits(file, glm::dvec3(0)).size()) / 1e6);
  measure("a step that hides half, and the renderer's set", [&] {
    GaussianSet odd = GaussianSet::where(count, pool, [](std::size_t i) { return i % 2 == 1; });
    EditState state = history.state();
    state.selected = std::move(odd);
    history.take({}, std::move(state));
    step({.kind = EditKind::hide});
    show();
  });
  measure("undo and the renderer's set", [&] {
    history.undo();
    show();
    history.redo();
  });
  renderer->set_drawn(GaussianSet());
  fmt::print("{:<44} {:8.1f} MB more\n", "at the end", resident_mb() - before);
}

}  // namespace
}  // namespace qs

int main(int count, char** words) {
  const std::size_t gaussians = count > 1 ? std::strtoull(words[1], nullptr, 10) : 10'000'000;
  qs::run(gaussians, count > 2 ? std::strtoull(words[2], nullptr, 10) : 0);
}
