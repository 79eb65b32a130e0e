// SPDX-License-Identifier: MIT
//
// A model in training, in the memory of a backend, and the passes of an iteration over it:
//   forward -> compare_with -> backward -> step
// Between iterations the set of Gaussians may change by a plan. One thread at a time uses a model.
// Equal calls give equal states, to the bit, on the same backend.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>

#include "raster/api/renderer.h"
#include "raster/kernel/adam.h"
#include "raster/kernel/gradient/mcmc.h"
#include "raster/kernel/loss.h"
#include "raster/train/photograph.h"
#include "raster/train/plan.h"

namespace qs::train {

/// What happens at the end of an iteration.
struct StepOrder {
  int iteration = 0;            ///< counts from 1
  bool counts_density = false;  ///< adds the view to the density statistics
  bool moves = true;            ///< takes Adam's step
  Rates rates;
  std::optional<Sparsity> sparsity;  ///< in the loss, beside the photograph
  std::optional<Noise> noise;        ///< moves means after the step
};

struct PassSeconds {
  double forward = 0, loss = 0, backward = 0, step = 0;
};

class TrainingModel {
 public:
  virtual ~TrainingModel() = default;

  /// "cpu", or "cuda" and the name of the GPU, for messages and logs.
  virtual std::string name() const = 0;

  virtual std::size_t size() const = 0;  ///< Gaussians

  /// Replaces the model.
  virtual void set_state(ModelState state) = 0;
  virtual int iteration() const = 0;       ///< of the last step
  virtual int changed_before() const = 0;  ///< see ModelState
  /// A reference to the model or to a copy of it. Valid until the next call.
  virtual const ModelState& state() = 0;
  /// The same of the parameters alone.
  virtual const Parameters& parameters() = 0;

  /// What strategies decide by. A reference to a copy, valid until the next call.
  virtual const GaussianFacts& facts() = 0;
  /// Changes the set of Gaussians. After an error the set is as before.
  virtual void apply(const Plan& plan) = 0;

  /// Draws a view. Of the settings, mode, sh_degree, background, antialiased (unset = no) and
  /// dilation are used. Throws Cancelled.
  virtual void forward(const Camera& camera, const RenderSettings& settings,
                       std::stop_token stop = {}) = 0;
  /// The drawn view, not clamped.
  virtual Image picture() = 0;
  /// Computes the loss of the drawn view and its derivatives by the pixels. The backend may keep
  /// the photograph of a number; one without is read again for every use.
  virtual void compare_with(std::optional<std::size_t> number, const Photograph& photograph) = 0;
  /// From the derivatives by the pixels to those by all parameters.
  virtual void backward() = 0;
  virtual void step(const StepOrder& order) = 0;

  /// The loss of the last comparison, or of the one before it, so that nobody waits for a GPU: it
  /// is known when the next view is drawn.
  virtual Loss recent_loss() = 0;
  /// The times of the same iteration on the GPU's clock. Unset if passes have run when they return.
  virtual std::optional<PassSeconds> pass_seconds() = 0;
  /// Memory of the GPU in use now, less that before the model was made. Unset on the CPU.
  virtual std::optional<std::uint64_t> gpu_memory_bytes() { return std::nullopt; }
};

/// `device` is an index into GpuReport::gpus; the CPU backend ignores it. `pool` must outlive the
/// model. Its passes throw Error(device) or std::bad_alloc if memory is short. Throws Error(device)
/// with the reason when the backend cannot run on this machine.
std::unique_ptr<TrainingModel> make_training_model(Backend backend, ThreadPool& pool,
                                                   int device = 0);

}  // namespace qs::train
