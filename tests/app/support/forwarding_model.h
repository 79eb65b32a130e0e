// SPDX-License-Identifier: MIT
//
// A model on the CPU behind an interface whose calls a test watches or breaks.
#pragma once

#include <memory>
#include <utility>

#include "learn/step/training_model.h"
#include "support/pool.h"

namespace qs::test {

/// Forwards every call. Tests derive from it and override the calls that they watch.
class ForwardingModel : public train::TrainingModel {
 public:
  std::string name() const override { return model_->name(); }
  std::size_t size() const override { return model_->size(); }
  void set_state(train::ModelState state) override { model_->set_state(std::move(state)); }
  int iteration() const override { return model_->iteration(); }
  int changed_before() const override { return model_->changed_before(); }
  const train::ModelState& state() override { return model_->state(); }
  const train::Parameters& parameters() override { return model_->parameters(); }
  const train::GaussianFacts& facts() override { return model_->facts(); }
  void apply(const train::Plan& plan) override { model_->apply(plan); }
  void forward(const Camera& camera, const RenderSettings& settings,
               std::stop_token stop) override {
    model_->forward(camera, settings, std::move(stop));
  }
  train::Quality quality(const train::Photograph& photograph) override {
    return model_->quality(photograph);
  }
  void compare_with(std::optional<std::size_t> number,
                    const train::Photograph& photograph) override {
    model_->compare_with(number, photograph);
  }
  void forget_photographs() override { model_->forget_photographs(); }
  void count_errors(std::optional<std::size_t> number,
                    const train::Photograph& photograph) override {
    model_->count_errors(number, photograph);
  }
  void backward(const train::BackwardOrder& order) override { model_->backward(order); }
  void step(const train::StepOrder& order) override { model_->step(order); }
  Loss recent_loss() override { return model_->recent_loss(); }
  std::optional<train::PassSeconds> pass_seconds() override { return model_->pass_seconds(); }

 private:
  std::unique_ptr<train::TrainingModel> model_ = train::make_training_model(Backend::cpu, pool());
};

}  // namespace qs::test
