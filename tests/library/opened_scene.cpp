// SPDX-License-Identifier: MIT
#include "library/opened_scene.h"

#include <algorithm>

#include "support/paths.h"

namespace qs::test {

std::filesystem::path plush() { return source_path("assets/plush.ply"); }
std::filesystem::path plush_cameras() { return source_path("assets/cameras.json"); }

QsCamera c_camera(const Camera& camera) {
  auto result = quadsplat::sized<QsCamera>();
  result.width = camera.width;
  result.height = camera.height;
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 4; ++column)
      result.view_from_world[4 * row + column] = camera.view_from_world[column][row];
  for (int axis = 0; axis < 2; ++axis) {
    result.focal_px[axis] = camera.focal_px[axis];
    result.center_px[axis] = camera.center_px[axis];
  }
  result.near_depth = camera.near_depth;
  return result;
}

void set_model(QsCamera& camera, const std::string& model, const std::vector<double>& parameters) {
  for (int axis = 0; axis < 2; ++axis) camera.focal_px[axis] = camera.center_px[axis] = 0;
  model.copy(camera.model, sizeof(camera.model));
  camera.parameter_count = static_cast<std::uint32_t>(parameters.size());
  std::copy(parameters.begin(), parameters.end(), camera.parameters);
}

QsCamera plush_camera(std::size_t number, int width, int height) {
  QsCamera camera = quadsplat::read_cameras(plush_cameras().string()).at(number);
  quadsplat::check(qs_camera_resize, &camera, width, height);
  return camera;
}

CloudArrays::CloudArrays(const GaussianCloud& cloud)
    : QsGaussians(quadsplat::sized<QsGaussians>()) {
  using quadsplat::array_of;
  static_assert(sizeof(glm::vec3) == 3 * sizeof(float));
  const auto count = static_cast<std::int64_t>(cloud.size());
  const auto floats = [](const auto& array) {
    return reinterpret_cast<const float*>(array.data());
  };
  for (const glm::quat& q : cloud.rotations)
    quaternions.insert(quaternions.end(), {q.w, q.x, q.y, q.z});
  antialiased = cloud.antialiased ? 1 : 0;
  means = array_of(floats(cloud.positions), {count, 3});
  scales = array_of(floats(cloud.log_scales), {count, 3});
  rotations = array_of(quaternions.data(), {count, 4});
  opacities = array_of(cloud.opacity_logits.data(), {count});
  colors = array_of(floats(cloud.sh), {count, sh_coefficient_count(cloud.sh_degree), 3});
}

QsPicture picture_of(Results& results, const QsCamera& camera, int tile_px) {
  using quadsplat::array_of;
  const std::int64_t width = camera.width, height = camera.height;
  const std::int64_t columns = (width + tile_px - 1) / tile_px,
                     rows = (height + tile_px - 1) / tile_px;
  const auto pixels = static_cast<std::size_t>(width * height);
  results.color.assign(3 * pixels, -1.0f);
  auto picture = quadsplat::sized<QsPicture>();
  picture.color = array_of(results.color.data(), {height, width, 3});
  const auto map = [&](auto& values, std::int64_t down, std::int64_t right) {
    values.assign(static_cast<std::size_t>(down * right), {});
    return array_of(values.data(), {down, right});
  };
  picture.alpha = map(results.alpha, height, width);
  picture.depth = map(results.depth, height, width);
  picture.median_depth = map(results.median_depth, height, width);
  picture.evaluated = map(results.evaluated, height, width);
  picture.pairs = map(results.pairs, rows, columns);
  picture.used = map(results.used, rows, columns);
  picture.counts = &results.counts;
  return picture;
}

Results rendered(quadsplat::Scene& scene, const QsCamera& camera, const QsSettings& settings) {
  Results results;
  scene.render(camera, picture_of(results, camera, settings.tile_px), settings);
  return results;
}

std::vector<float> colors(quadsplat::Scene& scene, const QsCamera& camera,
                          const QsSettings& settings) {
  std::vector<float> values(3 * static_cast<std::size_t>(camera.width) *
                            static_cast<std::size_t>(camera.height));
  auto picture = quadsplat::sized<QsPicture>();
  picture.color = quadsplat::array_of(values.data(), {camera.height, camera.width, 3});
  scene.render(camera, picture, settings);
  return values;
}

std::string sentence_of(const std::function<void()>& work, std::int32_t code) {
  try {
    work();
  } catch (const quadsplat::Error& error) {
    EXPECT_EQ(error.code(), code) << error.what();
    return error.what();
  }
  return "";
}

}  // namespace qs::test
