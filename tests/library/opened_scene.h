// SPDX-License-Identifier: MIT
//
// Contexts and scenes of libquadsplat for tests, arrays of a cloud, and pictures as vectors.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "quadsplat/quadsplat.hpp"
#include "raster/scene/camera.h"
#include "raster/scene/gaussian_cloud.h"

namespace qs::test {

/// The bundled scene, and the file of its cameras.
std::filesystem::path plush();
std::filesystem::path plush_cameras();

/// A context on the CPU.
inline quadsplat::Context cpu(int threads = 2) {
  return quadsplat::Context(QS_BACKEND_CPU, 0, threads);
}

QsCamera c_camera(const Camera& camera);

/// Gives the camera a model in the place of its focal lengths.
void set_model(QsCamera& camera, const std::string& model, const std::vector<double>& parameters);

/// A camera of the bundled scene, resized.
QsCamera plush_camera(std::size_t number, int width, int height);

/// A cloud's own arrays, as logarithms, logits and SH, and its quaternions in the order w x y z.
struct CloudArrays : QsGaussians {
  std::vector<float> quaternions;

  explicit CloudArrays(const GaussianCloud& cloud);
  CloudArrays(CloudArrays&&) = default;
};
inline CloudArrays gaussians_of(const GaussianCloud& cloud) { return CloudArrays(cloud); }

/// All results of a view, in arrays of their usual layout.
struct Results {
  std::vector<float> color, alpha, depth, median_depth;
  std::vector<std::uint32_t> evaluated, pairs, used;
  QsCounts counts = quadsplat::sized<QsCounts>();
};

/// Requests for all of them.
QsPicture picture_of(Results& results, const QsCamera& camera, int tile_px = 16);

/// Renders a view. Throws quadsplat::Error.
Results rendered(quadsplat::Scene& scene, const QsCamera& camera,
                 const QsSettings& settings = quadsplat::default_settings());

/// The colours alone.
std::vector<float> colors(quadsplat::Scene& scene, const QsCamera& camera,
                          const QsSettings& settings = quadsplat::default_settings());

/// The sentence of the Error that `work` throws, "" if it throws none. Expects that it has `code`.
std::string sentence_of(const std::function<void()>& work, std::int32_t code = QS_USAGE);

}  // namespace qs::test
