// SPDX-License-Identifier: MIT
#include "app/session/scene_edits.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iterator>
#include <utility>

#include <fmt/format.h>
#include <glm/gtc/matrix_transform.hpp>

#include "app/session/page_edits.h"
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

void warn_of_transform(const std::vector<EditStep>& steps, const std::filesystem::path& file) {
  if (std::ranges::any_of(steps, [](const EditStep& step) { return step.kind >= EditKind::scale; }))
    warn(
        fmt::format("{}: its scale and level are for convert; this command leaves the scene where "
                    "its cameras are",
                    file.string()));
}

EditsFile read_with_warnings(const EditOptions& options, const Scene& scene) {
  const std::filesystem::path& path = *options.file;
  if (!options.text) note_input(path);
  EditsFile file = options.text ? parse_edits(*options.text, path.string(), scene.cloud.origin)
                                : read_edits(path, scene.cloud.origin);
  for (const std::string& sentence : file.warnings) warn("warning: " + sentence);
  return file;
}

[[noreturn]] void refuse(const std::filesystem::path& file, const std::string& reason) {
  fail("{}: {}; --edits-anyway applies what does not depend on it", file.string(), reason);
}

// The results of steps do not fit another scene.
void forget_results(EditsFile& file) {
  if (const std::size_t left_out = std::erase_if(file.steps,
                                                 [](const EditStep& step) {
                                                   return step.kind == EditKind::select &&
                                                          needs_frame(step.select);
                                                 });
      left_out > 0)
    warn(fmt::format("{} of visible or touching Gaussians left out, because the scene is another",
                     counted(left_out, "selection")));
  for (EditStep& step : file.steps) {
    step.select.count.reset();
    step.select.crc.clear();
    step.select.members.reset();
  }
}

void edit_pages(Scene& scene, const EditOptions& options, ThreadPool& pool) {
  const EditsFile file = edits_of_tree(scene, options);
  warn_of_transform(file.steps, *options.file);
  const PageEdit edit = page_editor(file.steps, options.file->string(), scene);
  scene.stream->edit_pages(edit, pool);
  LodPage coarse{scene.cloud, std::vector<LodFacts>(scene.cloud.size())};  // for the first view
  edit(coarse);
  std::vector<std::uint32_t> left;
  for (std::uint32_t i = 0; i < scene.cloud.size(); ++i)
    if (coarse.cloud.opacity_logits[i] > -INFINITY) left.push_back(i);
  if (!left.empty()) scene.cloud = select(scene.cloud, left);
  scene.edits.steps =
      static_cast<int>(std::ranges::count_if(file.steps, takes_away, &EditStep::kind));
  scene.edits.crc = file_hash(*options.file);
  fmt::print(stderr, "edits: {}, carried out on each page of {} as it is read\n",
             counted(file.steps.size(), "step"), scene.path.string());
}

}  // namespace

EditsFile edits_of_tree(const Scene& scene, const EditOptions& options) {
  EditsFile file = read_with_warnings(options, scene);
  const EditedScene& of = file.scene;
  const bool is_other = (of.axes != scene.axes && !of.axes.empty()) ||
                        (of.bytes != scene.file_bytes && of.bytes != 0);
  if (is_other && !options.anyway)
    refuse(*options.file, "it is of a file of another size or of other axes");
  if (is_other) forget_results(file);
  return file;
}

EditedScene edited_scene(const Scene& scene, bool hashes) {
  const bool is_whole = !scene.stream;
  return {scene.path.filename().string(), hashes && is_whole ? file_hash(scene.path) : "",
          scene.file_bytes, is_whole ? std::max(scene.cloud.size(), scene.edits.removed.size()) : 0,
          scene.axes};
}

std::string other_scene(const EditedScene& of, const Scene& scene, std::size_t gaussians) {
  const std::string name = scene.path.filename().string();
  if (of.axes != scene.axes && !of.axes.empty())
    return fmt::format("its places are in axes {}, and the scene was read with {}", of.axes,
                       scene.axes);
  if (of.gaussians != gaussians && of.gaussians != 0 && !scene.stream)
    return fmt::format("it is of a scene of {} Gaussians, and {} has {}", grouped(of.gaussians),
                       name, grouped(gaussians));
  if (of.hash.empty()) return {};
  const std::string hash = file_hash(scene.path);
  if (of.hash != hash)
    return fmt::format("it is of a file with hash {}, and {} has {}", of.hash, name, hash);
  return {};
}

MeasuresFile measures_of(const Scene& scene, const std::filesystem::path& path,
                         const std::optional<std::string>& text) {
  MeasuresFile file = text ? parse_measures(*text, path.string(), scene.cloud.origin)
                           : read_measures(path, scene.cloud.origin);
  const std::string other = other_scene(file.scene, scene, edited_scene(scene, false).gaussians);
  if (!other.empty()) fail("{}: {}", path.string(), other);
  return file;
}

EditsFile edits_file(const Scene& scene, std::vector<EditStep> steps, bool hashes) {
  const GaussianSet& others = scene.edits.removed;
  EditsFile file{edited_scene(scene, hashes), {}};
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
  EditedCloud all{EditState(scene.cloud.size()), read_with_warnings(options, scene)};
  const std::string other = other_scene(all.file.scene, scene, scene.cloud.size());
  if (!other.empty() && !options.anyway) refuse(*options.file, other);
  if (!other.empty()) forget_results(all.file);

  ProgressBar bar("editing");
  const auto renderer = make_renderer(Backend::cpu, pool);
  const EditTools tools{scene.cloud,
                        pool,
                        seen_with(*renderer, {std::shared_ptr<void>(), &scene.cloud}, pool),
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
  if (scene.stream) return edit_pages(scene, options, pool);
  const EditedCloud all = edited(scene, options, pool);
  warn_of_transform(all.file.steps, *options.file);
  const GaussianSet rest = all.state.rest();
  if (rest.empty())
    fail(ErrorKind::usage, "{}: no Gaussian of {} is left", options.file->string(),
         scene.path.string());
  keep_edited(scene, all, rest);
}

}  // namespace qs
