// SPDX-License-Identifier: MIT
//
// A model in training, in the memory of a backend, and the passes of an iteration over it:
//   forward -> compare_with -> backward -> step
// Each pass requires the passes before it. Between iterations a plan may change the set of
// Gaussians. One thread at a time uses a model. Equal calls give equal states, to the bit, on the
// same backend.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>

#include "learn/gradient/adam.h"
#include "learn/gradient/density.h"
#include "learn/gradient/loss.h"
#include "learn/step/model_state.h"
#include "learn/step/photograph.h"
#include "learn/step/plan.h"
#include "raster/api/renderer.h"

namespace qs::train {

/// The work at the end of an iteration.
struct StepOrder {
  int iteration = 0;  ///< counts from 1
  /// Adds the view to the density statistics, with absolute gradients if backward() summed them.
  bool counts_density = false;
  /// The statistics count the view for the Gaussians that its culling mode lists in a tile. False:
  /// for the Gaussians that mode `exact` lists.
  bool counts_by_mode = false;
  bool moves = true;  ///< takes Adam's step
  /// Gradients are summed, and a step uses the sums of all iterations since the last step. A change
  /// of the set of Gaussians drops the sums.
  bool sums = false;
  /// With `sums`: the coefficients of colour beyond DC take no step and keep their sums.
  bool rest_waits = false;
  Rates rates;
  double field_rate = 0;  ///< learning rate of a colour field, which steps in every iteration
  std::optional<Sparsity> sparsity;  ///< in the loss, beside the photograph
  double mask_weight = 0;      ///< weight of the mean mask in the loss, if the model has masks
  std::optional<Noise> noise;  ///< moves means after the step
};

struct PassSeconds {
  double forward = 0, loss = 0, backward = 0, step = 0;
};

/// A picture compared with a photograph, over the pixels that are not masked.
struct Quality {
  double psnr = 0;  ///< dB; +infinity if they are equal
  double ssim = 0;  ///< with SsimBorder::zeros
};

class TrainingModel {
 public:
  virtual ~TrainingModel() = default;

  /// "cpu", or "cuda" and the name of the GPU, for messages and logs.
  virtual std::string name() const = 0;

  virtual std::size_t size() const = 0;  ///< Gaussians

  /// Replaces the model. `state` has at least one Gaussian, and all its arrays have one element per
  /// Gaussian. Throws Error(device) if the backend cannot train its colour field.
  virtual void set_state(ModelState state) = 0;
  virtual int iteration() const = 0;       ///< of the last step
  virtual int changed_before() const = 0;  ///< see ModelState
  /// A reference to the model or to a copy of it. Valid until the next call.
  virtual const ModelState& state() = 0;
  /// Like state(), for the parameters alone.
  virtual const Parameters& parameters() = 0;

  /// The numbers per Gaussian from which strategies decide. set_state() and apply() clear the
  /// counts of pixels. A reference to a copy, valid until the next call.
  virtual const GaussianFacts& facts() = 0;
  /// Replaces the set of Gaussians by the plan's. The sources in `plan` are indices below size().
  /// After an error the set is as before.
  virtual void apply(const Plan& plan) = 0;

  /// Draws a view; set_state() must have been called. Of the settings, mode, sh_degree, background,
  /// antialiased (unset = no) and dilation are used. Throws Cancelled.
  virtual void forward(const Camera& camera, const RenderSettings& settings,
                       std::stop_token stop = {}) = 0;
  /// Compares the view that forward() drew, clamped to 0..1, with a photograph of its size over the
  /// background. It waits for the result, and the passes of an iteration do not depend on it.
  virtual Quality quality(const Photograph& photograph) = 0;
  /// Computes the loss of the drawn view and its derivatives by the pixels. `photograph` has the
  /// size of the drawn view. `number` identifies it: the backend may keep a copy and does not read
  /// a photograph with the same number again. A photograph without a number is read at every call.
  virtual void compare_with(std::optional<std::size_t> number, const Photograph& photograph) = 0;
  /// From now on numbers identify other photographs.
  virtual void forget_photographs() {}
  /// Counts the pixels of the drawn view for every Gaussian, out of the lists of forward(), and
  /// adds them to the counts of facts(). Masked pixels do not count. The arguments are as for
  /// compare_with().
  virtual void count_errors(std::optional<std::size_t> number, const Photograph& photograph) = 0;
  /// Computes the derivatives by all parameters from the derivatives by the pixels.
  virtual void backward(const BackwardOrder& order) = 0;
  virtual void step(const StepOrder& order) = 0;

  /// The loss of this iteration's comparison, or of the comparison before it: reading it later
  /// avoids waiting for the GPU. At least one comparison must have been made.
  virtual Loss recent_loss() = 0;
  /// The times of the iteration of recent_loss() on the GPU's clock. Unset if passes have run when
  /// they return.
  virtual std::optional<PassSeconds> pass_seconds() = 0;
  /// Memory of the GPU in use now, minus the memory in use before the model was made. Unset on the
  /// CPU.
  virtual std::optional<std::uint64_t> gpu_memory_bytes() { return std::nullopt; }
};

/// `pool` must outlive the model. `device` is an index into GpuReport::gpus, or kFirstGpu; the CPU
/// backend ignores it. The model's passes throw Error(device) or std::bad_alloc if memory is short.
/// Throws Error(device) with the reason when the backend cannot run on this machine.
std::unique_ptr<TrainingModel> make_training_model(Backend backend, ThreadPool& pool,
                                                   int device = kFirstGpu);

}  // namespace qs::train
