// SPDX-License-Identifier: MIT
//
// The CPU's model in training. Results do not depend on the number of threads.
#pragma once

#include <optional>
#include <vector>

#include "learn/step/cpu/loss.h"
#include "learn/step/cpu/passes.h"
#include "learn/step/training_model.h"

namespace qs::cpu::train {

class CpuModel final : public qs::train::TrainingModel {
 public:
  explicit CpuModel(ThreadPool& pool) : pool_(pool) {}

  std::string name() const override { return kBackendNames[static_cast<int>(Backend::cpu)]; }

  std::size_t size() const override { return state_.size(); }
  int iteration() const override { return state_.iteration; }
  int changed_before() const override { return state_.changed_before; }
  void set_state(ModelState state) override;
  const ModelState& state() override { return state_; }
  const qs::train::Parameters& parameters() override { return state_.parameters; }

  const GaussianFacts& facts() override;
  void apply(const Plan& plan) override { set_state(changed(state_, plan)); }

  void forward(const Camera& camera, const RenderSettings& settings, std::stop_token stop) override;
  Quality quality(const Photograph& photograph) override;
  void compare_with(std::optional<std::size_t> number, const Photograph& photograph) override;
  void count_errors(std::optional<std::size_t> number, const Photograph& photograph) override;
  void backward(const BackwardOrder& order) override;
  void step(const StepOrder& order) override;

  Loss recent_loss() override { return result_; }
  std::optional<qs::train::PassSeconds> pass_seconds() override { return std::nullopt; }

 private:
  /// The parameters that the passes draw.
  const qs::train::Parameters& drawn() const {
    return state_.codes.exist() ? coded_ : state_.parameters;
  }
  const FieldGradient<float>* field() const { return field_ ? &*field_ : nullptr; }
  StepView view() const { return {camera_, settings_, pool_, stop_}; }

  ThreadPool& pool_;
  ModelState state_;
  PixelCounts counts_;
  GaussianFacts facts_;  ///< the copy that facts() returns

  std::optional<FieldGradient<float>> field_;  ///< field of the iteration, if the model has a field

  qs::train::Parameters coded_;  ///< parameters with coded shapes, if the model has codes

  // Of the drawn view.
  Camera camera_;
  RenderSettings settings_;
  std::stop_token stop_;

  ForwardFrame<float> frame_;
  SsimFields<float> loss_;
  Loss result_;
  std::vector<glm::vec3> d_color_;
  BackwardScratch<float> backward_;
  Gradients<float> gradients_;
};

}  // namespace qs::cpu::train
