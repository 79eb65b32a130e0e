// SPDX-License-Identifier: MIT
#include "app/support/training.h"

#include <cmath>
#include <cstring>
#include <random>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "io/picture/image_file.h"
#include "learn/run/initial.h"
#include "raster/api/renderer.h"
#include "support/pool.h"
#include "support/scene_files.h"

namespace qs::test {

train::Parameters ball_of_gaussians(std::size_t count, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<float> normal;
  std::uniform_real_distribution<float> uniform(-1, 1);
  train::Parameters scene;
  scene.sh_degree = 0;
  scene.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    glm::vec3 p;
    do p = {uniform(random), uniform(random), uniform(random)};
    while (glm::dot(p, p) > 1);
    scene.means[i] = p;
    scene.log_scales[i] =
        glm::vec3(-2.5f) + 0.4f * glm::vec3(normal(random), normal(random), normal(random));
    scene.rotations[i] = glm::quat(normal(random), normal(random), normal(random), normal(random));
    scene.opacity_logits[i] = 1 + normal(random);
    scene.sh[i] = 1.2f * glm::vec3(uniform(random), uniform(random), uniform(random));
  }
  return scene;
}

train::Parameters perturbed(train::Parameters scene, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<float> normal;
  const auto noise = [&] { return glm::vec3(normal(random), normal(random), normal(random)); };
  for (std::size_t i = 0; i < scene.size(); ++i) {
    scene.means[i] += 0.08f * noise();
    scene.log_scales[i] += 0.5f * noise();
    for (int k = 0; k < 4; ++k) scene.rotations[i][k] += 0.3f * normal(random);
    scene.opacity_logits[i] += 0.5f * normal(random);
    scene.sh[i] += 0.4f * noise();
  }
  return scene;
}

std::vector<Camera> sphere_cameras(int count) {
  constexpr double kGoldenAngle = 2.399963229728653;
  std::vector<Camera> cameras;
  for (int i = 0; i < count; ++i) {
    const double height = 0.8 * (2 * (i + 0.5) / count - 1);
    const double radius = std::sqrt(1 - height * height), angle = kGoldenAngle * i;
    const glm::dvec3 direction(radius * std::cos(angle), height, radius * std::sin(angle));
    cameras.push_back(look_at(3.5 * direction, glm::dvec3(0), {0, -1, 0}, 0.6, 64, 48));
    cameras.back().name = fmt::format("view{:02}", i);
  }
  return cameras;
}

train::DataSet data_set_of(const train::Parameters& scene, int views) {
  const auto renderer = make_renderer(Backend::cpu, pool());
  renderer->upload(to_cloud(scene, false), {});
  train::DataSet data;
  data.folder = "synthetic";
  const std::vector<Camera> cameras = sphere_cameras(views);
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    train::PhotographView view;
    view.camera = cameras[i];
    view.source.file = cameras[i].name + ".png";
    for (const float value : renderer->render(cameras[i]).color.values)
      view.rgb.push_back(to_8bit(value));
    (i % 4 == 0 ? data.test : data.training).push_back(std::move(view));
  }
  return data;
}

void write_data_set(const train::DataSet& data, const std::filesystem::path& folder) {
  std::filesystem::create_directories(folder / "images");
  for (const auto* views : {&data.training, &data.test}) {
    for (const train::PhotographView& view : *views)
      write_image(view.image(), folder / "images" / view.source.file);
  }
  write_cameras(pinhole_cameras(data.cameras()), folder / "cameras.json");
}

train::Trainer trainer_on(Backend backend, const train::TrainSettings& settings,
                          const train::DataSet& data, train::ModelState state, int threads) {
  if (train::find_strategy(settings.strategy).has_masks && !state.parameters.has_masks) {
    const int iteration = state.iteration;
    state = train::ModelState::starting_with(train::with_masks(std::move(state.parameters)));
    state.iteration = iteration;
  }
  auto model = train::make_training_model(backend, pool(threads));
  model->set_state(std::move(state));
  return {settings, data, std::move(model), pool(threads)};
}

void expect_same(const train::ModelState& a, const train::ModelState& b) {
  EXPECT_EQ(a.iteration, b.iteration);
  EXPECT_EQ(a.changed_before, b.changed_before);
  EXPECT_EQ(a.adam.steps, b.adam.steps);
  EXPECT_EQ(a.adam.rest_steps, b.adam.rest_steps);
  const auto same_bits = [](const auto& x, const auto& y) {
    ASSERT_EQ(x.size(), y.size());
    // memcmp() takes no null pointers.
    const bool equal = x.empty() || std::memcmp(x.data(), y.data(), x.size() * sizeof x[0]) == 0;
    EXPECT_TRUE(equal);
  };
  const auto same = [&](std::size_t, const auto& x, const auto& y) { same_bits(x, y); };
  train::for_each_array(same, a.parameters, b.parameters);
  train::for_each_array(same, a.adam.first, b.adam.first);
  train::for_each_array(same, a.summed, b.summed);
  train::for_each_array(same, a.adam.second, b.adam.second);
  same_bits(a.density.sums, b.density.sums);
  same_bits(a.density.views, b.density.views);
  same_bits(a.density.absolute, b.density.absolute);
  EXPECT_EQ(a.color_field.steps, b.color_field.steps);
  same_bits(a.color_field.field.grid_values, b.color_field.field.grid_values);
  same_bits(a.color_field.field.weights, b.color_field.field.weights);
  same_bits(a.color_field.first, b.color_field.first);
  same_bits(a.color_field.second, b.color_field.second);
  for (const auto& [x, y] :
       {std::pair{&a.codes.scales, &b.codes.scales}, {&a.codes.rotations, &b.codes.rotations}}) {
    EXPECT_EQ(x->steps, y->steps);
    same_bits(x->codebook.values, y->codebook.values);
    same_bits(x->first, y->first);
    same_bits(x->second, y->second);
  }
  EXPECT_EQ(a.growth.initial, b.growth.initial);
  EXPECT_EQ(a.growth.budget, b.growth.budget);
}

}  // namespace qs::test
