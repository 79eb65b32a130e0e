// SPDX-License-Identifier: MIT
#include "library/api/scene.h"

#include <algorithm>
#include <utility>

#include <glm/common.hpp>

#include "base/fail.h"
#include "io/camera/cameras.h"
#include "io/scene/reader.h"
#include "library/check/structs.h"

namespace qs::library {
namespace {

// The numbers of the Gaussians that were kept; empty if all were.
std::vector<std::uint32_t> kept_numbers(std::size_t kept, const std::vector<std::size_t>& removed) {
  std::vector<std::uint32_t> numbers;
  if (removed.empty()) return numbers;
  numbers.reserve(kept);
  auto next = removed.begin();
  for (std::size_t number = 0; numbers.size() < kept; ++number) {
    if (next != removed.end() && *next == number)
      ++next;
    else
      numbers.push_back(static_cast<std::uint32_t>(number));
  }
  return numbers;
}

}  // namespace

OpenScene::OpenScene(std::shared_ptr<Context> context, Scene scene,
                     std::vector<std::size_t> not_drawn)
    : context_(std::move(context)),
      scene_(std::make_shared<const Scene>(std::move(scene))),
      not_drawn_(not_drawn.size()),
      numbers_(kept_numbers(scene_->cloud.size(), not_drawn)) {
  path_ = scene_->path.string();
  if (const auto file = path_.empty() ? std::nullopt : find_cameras_file(scene_->path))
    cameras_path_ = file->string();
  for (const std::string& warning : scene_->warnings)
    warnings_ += (warnings_.empty() ? "" : "\n") + warning;
  white_background_ = !scene_->path.empty() && model_wants_white_background(scene_->path);
  const Array<glm::vec3>& positions = scene_->cloud.positions;
  if (!positions.empty()) low_ = high_ = positions.front();
  for (const glm::vec3& position : positions) {
    low_ = glm::min(low_, position);
    high_ = glm::max(high_, position);
  }
}

QsSceneFacts OpenScene::facts() const {
  const GaussianCloud& cloud = scene_->cloud;
  QsSceneFacts facts{};
  facts.sh_degree = cloud.sh_degree;
  facts.gaussians = cloud.size() + not_drawn_;
  facts.not_drawn = not_drawn_;
  facts.file_bytes = scene_->file_bytes;
  std::copy_n(&low_.x, 3, facts.low);
  std::copy_n(&high_.x, 3, facts.high);
  facts.antialiased = cloud.antialiased ? 1 : 0;
  facts.white_background = white_background_ ? 1 : 0;
  facts.path = path_.c_str();
  facts.format = scene_->format.c_str();
  facts.axes = scene_->axes.c_str();
  facts.vertical_axis = scene_->vertical_axis.c_str();
  facts.cameras_path = cameras_path_.c_str();
  facts.warnings = warnings_.c_str();
  return facts;
}

Renderer& OpenScene::renderer(const std::stop_token& stop) {
  if (!renderer_) {
    std::unique_ptr<Renderer> made = context_->make_renderer();
    made->upload(std::shared_ptr<const GaussianCloud>(scene_, &scene_->cloud), {{}, stop});
    renderer_ = std::move(made);
  }
  return *renderer_;
}

std::vector<std::uint32_t> OpenScene::numbers_of(const std::vector<std::uint32_t>& indices) const {
  std::vector<std::uint32_t> numbers(indices.size());
  std::ranges::transform(indices, numbers.begin(),
                         [&](std::uint32_t index) { return numbers_[index]; });
  return numbers;
}

std::optional<std::size_t> OpenScene::index_of(std::size_t number) const {
  if (keeps_numbers()) {  // also of a cloud without Gaussians
    if (number < cloud().size()) return number;
    return std::nullopt;
  }
  const auto found = std::ranges::lower_bound(numbers_, number);
  if (found == numbers_.end() || *found != number) return std::nullopt;
  return static_cast<std::size_t>(found - numbers_.begin());
}

}  // namespace qs::library

using namespace qs::library;

int32_t qs_scene_load(QsContext* context, const char* path, const char* axes, QsSceneHandle** scene,
                      char* message) {
  return library::call(__func__, message, "scene", scene, [&](const char* function) {
    *scene = nullptr;
    require(context, {function, "context"});
    require_text(path, {function, "path"});
    const Use use(*context->context, {function, "context"});
    ReadOptions options;
    options.axes = axes != nullptr ? axes : "";
    options.keeps_place = true;  // the cameras of callers have the file's coordinates
    options.progress.stop = use.stop();
    *scene =
        new QsSceneHandle{OpenScene(context->context, read_scene(path, use.pool(), options), {})};
  });
}

int32_t qs_scene_facts(const QsSceneHandle* scene, QsSceneFacts* facts, char* message) {
  return library::call(__func__, message, "scene", scene, [&](const char* function) {
    write_struct(scene->scene.facts(), facts, {function, "facts"});
  });
}

void qs_scene_close(QsSceneHandle* scene) {
  // A forked process has none of the threads and no CUDA context, with which a renderer is freed.
  if (scene == nullptr || !scene->scene.context().is_of_this_process()) return;
  delete scene;
}
