// SPDX-License-Identifier: MIT
#include "app/session/scene_edits.h"

#include <algorithm>
#include <cstdio>
#include <iterator>
#include <utility>

#include <fmt/format.h>
#include <glm/gtc/matrix_transform.hpp>

#include "base/fail.h"
#include "base/progress_bar.h"
#include "base/text.h"
#include "base/warn.h"
#include "io/bytes/file_guard.h"
#include "io/bytes/file_hash.h"
#include "raster/api/renderer.h"
#include "raster/scene/cloud_order.h"

namespace qs {
namespace {

bool is_of_picture(const EditStep& step) {
  return step.kind == EditKind::select && draws_in_picture(step.select.tool) &&
         step.select.kind != SelectKind::through;
}

// Empty if the edits are of this scene. Hashes its file only if the edits have a hash.
std::string other_scene(const EditedScene& of, const Scene& scene) {
  const std::string name = scene.path.filename().string();
  const std::size_t gaussians = scene.cloud.size();
  if (of.axes != scene.axes && !of.axes.empty())
    return fmt::format("its places are in axes {}, and the scene was read with {}", of.axes,
                       scene.axes);
  if (of.gaussians != gaussians && of.gaussians != 0)
    return fmt::format("it is of a scene of {} Gaussians, and {} has {}", grouped(of.gaussians),
                       name, grouped(gaussians));
  if (of.hash.empty()) return {};
  const std::string hash = file_hash(scene.path);
  if (of.hash != hash)
    return fmt::format("it is of a file with hash {}, and {} has {}", of.hash, name, hash);
  return {};
}

// The results of steps do not fit another scene.
void forget_results(EditsFile& file) {
  if (const std::size_t left_out = std::erase_if(file.steps, is_of_picture); left_out > 0)
    warn(fmt::format("{} of visible or touching Gaussians left out, because the scene is another",
                     counted(left_out, "selection")));
  for (EditStep& step : file.steps) {
    step.select.count.reset();
    step.select.crc.clear();
    step.select.members.reset();
  }
}

}  // namespace

EditsFile edits_file(const Scene& scene, std::vector<EditStep> steps, bool hashes) {
  const GaussianSet& others = scene.edits.removed;
  EditsFile file{{scene.path.filename().string(), hashes ? file_hash(scene.path) : "",
                  scene.file_bytes, std::max(scene.cloud.size(), others.size()), scene.axes},
                 {}};
  if (!others.empty()) {
    const std::vector<std::uint32_t> numbers = others.complement().numbers();
    for (EditStep& step : steps) {
      step.select.crc.clear();
      if (!step.select.members) continue;
      GaussianSet members(others.size());
      for (const GaussianRun& run : *step.select.members)
        for (std::uint64_t i = 0; i < run.count; ++i) members.add(numbers[run.first + i]);
      step.select.members = members.runs();
    }
    file.steps = {{.select = {.tool = SelectTool::list, .members = others.runs()}},
                  {.kind = EditKind::remove}};
  }
  std::ranges::move(steps, std::back_inserter(file.steps));
  return file;
}

EditedCloud edited(const Scene& scene, const EditOptions& options, ThreadPool& pool,
                   const std::function<void(const EditStep&, const EditState&)>& each) {
  const std::string source = options.file->string();
  note_input(*options.file);
  EditedCloud all{EditState(scene.cloud.size()), read_edits(*options.file, scene.cloud.origin)};
  for (const std::string& sentence : all.file.warnings) warn("warning: " + sentence);
  const std::string other = other_scene(all.file.scene, scene);
  if (!other.empty() && !options.anyway)
    fail("{}: {}; --edits-anyway applies what does not depend on it", source, other);
  if (!other.empty()) forget_results(all.file);

  ProgressBar bar("editing");
  std::unique_ptr<Renderer> renderer;
  EditTools tools{scene.cloud,
                  pool,
                  [&, seen = SeenInPicture()](const GaussianSet& rest, const Camera& camera,
                                              const Shape& shape, float weight) mutable {
                    if (!renderer) {
                      renderer = make_renderer(Backend::cpu, pool);
                      seen = seen_with(*renderer, {std::shared_ptr<void>(), &scene.cloud}, pool);
                    }
                    return seen(rest, camera, shape, weight);
                  },
                  set_hash,
                  bar.progress(),
                  options.recomputes};
  for (std::size_t i = 0; i < all.file.steps.size(); ++i) {
    const EditStep& step = all.file.steps[i];
    const std::string differs =
        carry_out(step, tools, fmt::format("{}: step {}", source, i + 1), all.state);
    if (!differs.empty()) warn(differs);
    if (each) each(step, all.state);
    if (step.kind == EditKind::scale)
      all.transform = glm::scale(glm::dmat4(1), glm::dvec3(step.factor)) * all.transform;
    if (step.kind == EditKind::level) all.transform = glm::mat4_cast(step.rotation) * all.transform;
    bar.progress().update(static_cast<float>(i + 1) / static_cast<float>(all.file.steps.size()));
  }
  bar.hide();
  const GaussianSet rest = all.state.rest();
  fmt::print(stderr, "edits: {}, {} of {} Gaussians are left, {} selected\n",
             counted(all.file.steps.size(), "step"), grouped(rest.count()), grouped(rest.size()),
             grouped(all.state.selected.count()));
  return all;
}

void keep_edited(Scene& scene, const EditedCloud& edited, const GaussianSet& kept) {
  const auto steps = std::ranges::count_if(edited.file.steps, takes_away, &EditStep::kind);
  if (steps == 0 && kept.count() == kept.size()) return;
  scene.edits.remove(std::max(1, static_cast<int>(steps)), kept.complement());
  scene.cloud = select(scene.cloud, kept.numbers());
}

void apply_edits(Scene& scene, const EditOptions& options, ThreadPool& pool) {
  if (!options.file) return;
  if (scene.stream)
    fail(ErrorKind::usage, "{}: {} is a tree that is not read whole: it cannot be edited",
         options.file->string(), scene.path.string());
  const EditedCloud all = edited(scene, options, pool);
  if (all.transform != glm::dmat4(1))
    warn(
        fmt::format("{}: its scale and level are for convert; this command leaves the scene where "
                    "its cameras are",
                    options.file->string()));
  const GaussianSet rest = all.state.rest();
  if (rest.empty())
    fail(ErrorKind::usage, "{}: no Gaussian of {} is left", options.file->string(),
         scene.path.string());
  keep_edited(scene, all, rest);
}

}  // namespace qs
