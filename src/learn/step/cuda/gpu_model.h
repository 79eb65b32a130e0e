// SPDX-License-Identifier: MIT
//
// A model in training in the memory of a GPU. The passes do not copy the model, and an iteration
// waits for the GPU once, for the number of pairs. This header is plain C++: users need no CUDA
// headers.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include <glm/vec2.hpp>

#include "learn/step/training_model.h"

namespace qs::cuda::train {

/// Per pixel of the drawn view, row by row, as the CPU's ForwardFrame has them.
struct PixelCopies {
  std::vector<glm::vec3> color;
  std::vector<float> transmittance;
  std::vector<std::uint32_t> last;
};

/// As the CPU's Gradients.
struct GradientCopies {
  qs::train::Parameters by;
  std::vector<glm::vec2> mean_px, absolute_px;
  std::vector<std::uint8_t> visible;
};

/// Derivatives by a colour field, as the CPU's FieldGradients.
struct FieldGradientCopies {
  std::vector<double> grid;
  std::vector<float> weights;
};

class GpuModel final : public qs::train::TrainingModel {
 public:
  /// `device` is an index into GpuReport::gpus. Throws Error(device).
  explicit GpuModel(int device = 0);
  ~GpuModel() override;

  std::string name() const override;

  std::size_t size() const override;
  int iteration() const override;
  int changed_before() const override;
  void set_state(qs::train::ModelState state) override;
  const qs::train::ModelState& state() override;
  const qs::train::Parameters& parameters() override;
  const qs::train::GaussianFacts& facts() override;
  void apply(const qs::train::Plan& plan) override;

  void forward(const Camera& camera, const RenderSettings& settings,
               std::stop_token stop = {}) override;
  qs::train::Quality quality(const qs::train::Photograph& photograph) override;
  /// Keeps the photographs in the GPU's memory while they fill less than half of it.
  void compare_with(std::optional<std::size_t> number,
                    const qs::train::Photograph& photograph) override;
  void forget_photographs() override;
  void count_errors(std::optional<std::size_t> number,
                    const qs::train::Photograph& photograph) override;
  void backward(const qs::train::BackwardOrder& order) override;
  void step(const qs::train::StepOrder& order) override;
  Loss recent_loss() override;
  std::optional<qs::train::PassSeconds> pass_seconds() override;
  std::optional<std::uint64_t> gpu_memory_bytes() override;

  /// Waits until all passes have run; passes return earlier.
  void wait() const;

  // For tests; they wait.
  /// Compares the drawn view with a picture, per pixel, row by row. `mask` as in Photograph.
  void compare(std::span<const glm::vec3> target, std::span<const std::uint8_t> mask = {});
  /// Replaces the derivatives by the pixels.
  void set_pixel_gradients(std::span<const glm::vec3> d_color);
  Loss loss() const;  ///< of the last comparison
  PixelCopies pixels() const;
  std::vector<glm::vec3> pixel_gradients() const;
  GradientCopies gradients() const;
  FieldGradientCopies field_gradients() const;  ///< after backward(), of a model with a field
  std::uint32_t pairs() const;                  ///< of tiles and Gaussians in the drawn view

 private:
  struct State;
  State& gpu() const;  ///< selects the GPU

  std::unique_ptr<State> state_;
};

}  // namespace qs::cuda::train
