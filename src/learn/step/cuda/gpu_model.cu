// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cassert>
#include <utility>

#include "learn/diff/cuda/compare.h"
#include "learn/gradient/integer_sum.h"
#include "learn/step/cuda/adam.cuh"
#include "learn/step/cuda/codes.cuh"
#include "learn/step/cuda/density.cuh"
#include "learn/step/cuda/field.cuh"
#include "learn/step/cuda/forward.cuh"
#include "learn/step/cuda/gpu_model.h"
#include "learn/step/cuda/loss.cuh"
#include "learn/step/cuda/pass_clock.cuh"
#include "raster/cuda/common/gpu_info.h"
#include "raster/cuda/common/stream.cuh"

namespace qs::cuda::train {

namespace {

/// A stream for work that the passes after it do not need at once: the sums of the loss, the step
/// of the colours and the next view's colours, beside which that view is projected and listed, and
/// its photograph.
class SideStream {
 public:
  SideStream(int device, bool urgent) : stream_(device, urgent) {}

  /// Calls `work` with the stream, in which it follows all that was enqueued in `from`.
  template <class Work>
  void fork(cudaStream_t from, const Work& work) {
    begin_.record(from);
    begin_.make_wait(stream_);
    run(work);
  }
  /// Calls `work` with the stream.
  template <class Work>
  void run(const Work& work) {
    work(static_cast<cudaStream_t>(stream_));
    end_.record(stream_);
    pending_ = true;
  }
  /// Work enqueued in `to` from now on follows all work of this stream.
  void join(cudaStream_t to) {
    if (pending_) end_.make_wait(to);
    pending_ = false;
  }

 private:
  Stream stream_;
  Event begin_, end_;
  bool pending_ = false;
};

/// The highest degree of coefficients that are not all zero.
int used_degree(const qs::train::Parameters& moments) {
  std::size_t used = 0;
  for (std::size_t at = 0; at < moments.sh.size(); ++at)
    if (moments.sh[at] != glm::vec3(0)) used = std::max(used, at % moments.sh_stride());
  int degree = 0;
  while (static_cast<std::size_t>(sh_coefficient_count(degree)) <= used) ++degree;
  return degree;
}

}  // namespace

struct GpuModel::State {
  explicit State(int device_index)
      : device(device_index), stream(device_index, true), side(device_index, false) {}

  int device;
  Stream stream;  // selects the GPU
  SideStream side;
  std::size_t free_before = DeviceMemory::now().free;
  Parameters parameters;
  AdamState adam;
  GradientSums sums;
  DensityStatistics density;
  PixelCounts counts;

  /// Memory of apply(), exchanged with the model's memory.
  struct Next {
    DeviceBuffer<std::uint32_t> sources, moment_sources;
    Parameters parameters, first, second;
    DensityStatistics density;
  } next;
  qs::train::ModelState host;      ///< the copy that state() returns, with the current iteration,
                                   ///< changed_before and growth
  qs::train::GaussianFacts facts;  ///< the copy that facts() returns, in memory that is reused

  std::vector<DevicePhotograph> photographs;  ///< photographs by their numbers
  DevicePhotograph passing;                   ///< the last photograph that is not kept

  ForwardFrame frame;
  LossScratch loss;
  LossCopy losses[2];             ///< losses of comparisons with even and odd numbers
  std::uint64_t comparisons = 0;  ///< since set_state()
  DeviceBuffer<glm::vec3> target, d_color;
  DeviceBuffer<std::uint8_t> mask;  ///< the mask that compare() reads
  ErrorScratch errors;
  DeviceBuffer<std::byte> quality;  ///< sums of sums_of()
  BackwardScratch backward;
  Gradients gradients;
  DeviceField field;
  ShapeCodes codes;
  PassClock clock;

  // Of the drawn view.
  Camera camera;
  RenderSettings settings;
  std::stop_token stop;

  /// Sets host.summed.
  void download_sums() {
    host.summed = {};
    host.summed.sh_degree = parameters.sh_degree;
    host.summed.has_masks = parameters.has_masks;
    if (sums.empty()) return;
    host.summed = download(sums.by, stream);
    const std::size_t stride = host.summed.sh_stride();
    for (std::size_t at = 0; at < host.summed.sh.size(); ++at)
      if (at % stride == 0 ? !sums.has_others : !sums.has_rest) host.summed.sh[at] = glm::vec3(0);
    if (sums.has_others) return;
    qs::train::Parameters zeros;
    zeros.sh_degree = host.summed.sh_degree;
    zeros.has_masks = host.summed.has_masks;
    zeros.sh = std::move(host.summed.sh);
    zeros.resize(host.summed.size());
    host.summed = std::move(zeros);
  }

  /// Fills `next` by the plan.
  void gather_next(const qs::train::Plan& plan);

  /// The parameters that the passes draw.
  ParametersView drawn() {
    return codes.exist() ? codes.drawn(parameters.view()) : parameters.view();
  }

  StepView view() const { return {camera, settings, stream, stop}; }
  std::size_t pixels() const { return view().pixels(); }

  /// The drawn view and `target`. `target_mask` may be null.
  Comparison comparison(const std::uint8_t* target_mask, std::size_t counted) {
    return {camera.width,  camera.height, frame.pixels.colors(),
            target.data(), target_mask,   counted};
  }
  /// The same for a photograph, which is copied to `target`. The last reader of `target` is done,
  /// because forward() has forked the stream since then, or compare() has.
  Comparison comparison(std::optional<std::size_t> number,
                        const qs::train::Photograph& photograph) {
    assert(photograph.rgb.size() == 3 * pixels());
    const DevicePhotograph& device_photograph = uploaded(number, photograph);
    side.run(
        [&](cudaStream_t beside) { device_photograph.over(settings.background, beside, target); });
    side.join(stream);
    return comparison(device_photograph.has_mask ? device_photograph.mask.data() : nullptr,
                      device_photograph.counted);
  }

  void compare(const Comparison& pictures) {
    side.join(stream);  // the sums of the last loss are in use
    train::compare(pictures, stream, loss, d_color);
    clock.end(1, stream);
    side.fork(stream, [&](cudaStream_t beside) {
      losses[comparisons % 2].begin(loss, 3 * static_cast<double>(pictures.counted), beside);
    });
    ++comparisons;
  }

  /// Waits.
  diff::ComparisonSums sums_of(const Comparison& compared) {
    const auto colors = [&](const glm::vec3* pixels) {
      return diff::GivenPicture{pixels, std::ptrdiff_t{3} * compared.width, 3, 1, sizeof(float)};
    };
    const diff::GivenPictures pictures{
        colors(compared.color), colors(compared.target), {compared.mask, compared.width, 1, 0, 1},
        compared.width,         compared.height,         0};
    quality.reserve("the quality", diff::bytes_to_compare(pictures));
    return diff::compare(pictures, true, {stream, stop}, quality.data());
  }

  /// The photograph in the memory of the GPU.
  const DevicePhotograph& uploaded(std::optional<std::size_t> number,
                                   const qs::train::Photograph& host_photograph) {
    if (number && *number >= photographs.size()) photographs.resize(*number + 1);
    if (number && photographs[*number].pixels > 0) return photographs[*number];
    const std::uint64_t bytes = DevicePhotograph::bytes_of(host_photograph);
    const bool keeps = number && bytes < DeviceMemory::now().free / 2;
    DevicePhotograph& result = keeps ? photographs[*number] : passing;
    result.upload(host_photograph, stream);
    return result;
  }

  /// Frees the photographs, which are copied again when they are needed. False if there are none.
  bool free_photographs() {
    check(cudaStreamSynchronize(stream), "training");
    const bool any = std::any_of(photographs.begin(), photographs.end(),
                                 [](const DevicePhotograph& each) { return each.pixels > 0; });
    photographs.clear();
    return any;
  }

  /// Calls `work`, and again without photographs if memory is short.
  template <class Work>
  void with_memory(const Work& work) {
    making_room([&] { return free_photographs(); }, work);
  }

  /// Waits for the copy, because the caller may free the host's memory.
  template <class T>
  void copy_pixels(std::span<const T> from, DeviceBuffer<T>& to) {
    assert(from.size() == pixels());
    copy_to_device(from.data(), to, from.size(), stream);
  }
};

GpuModel::GpuModel(int device) {
  require_gpu(device);
  state_ = std::make_unique<State>(device);
}

GpuModel::~GpuModel() {
  cudaSetDevice(state_->device);
  state_->side.join(state_->stream);
  cudaStreamSynchronize(state_->stream);  // passes may still run
}

GpuModel::State& GpuModel::gpu() const {
  check(cudaSetDevice(state_->device), "cudaSetDevice");
  return *state_;
}

std::string GpuModel::name() const {
  return std::string(kBackendNames[static_cast<int>(Backend::cuda)]) + ", " +
         inspect_gpu(state_->device).name;
}

std::size_t GpuModel::size() const { return state_->parameters.count; }

int GpuModel::iteration() const { return state_->host.iteration; }

int GpuModel::changed_before() const { return state_->host.changed_before; }

void GpuModel::set_state(qs::train::ModelState state) {
  if (state.color_field.exists()) require_small_network(state.color_field.field);
  State& s = gpu();
  s.side.join(s.stream);
  s.host.iteration = state.iteration;
  s.host.changed_before = state.changed_before;
  s.host.growth = state.growth;
  s.adam.steps = state.adam.steps;
  s.adam.rest_steps = state.adam.rest_steps;
  s.sums.has_rest = s.sums.has_others = state.summed.size() > 0;
  if (!s.sums.empty()) upload(state.summed, s.stream, s.sums.by);
  s.adam.sh_degree = std::max(used_degree(state.adam.first), used_degree(state.adam.second));
  s.comparisons = 0;
  s.counts.count = 0;
  upload(state.parameters, s.stream, s.parameters);
  upload(state.adam.first, s.stream, s.adam.first);
  upload(state.adam.second, s.stream, s.adam.second);
  s.density.upload(state.density, s.stream);
  s.field.upload(state.color_field, s.stream);
  s.codes.upload(state.codes, s.stream);
}

const qs::train::Parameters& GpuModel::parameters() {
  State& s = gpu();
  s.side.join(s.stream);
  s.host.parameters = download(s.parameters, s.stream);
  return s.host.parameters;
}

const qs::train::ModelState& GpuModel::state() {
  parameters();
  State& s = gpu();
  s.host.adam = {download(s.adam.first, s.stream), download(s.adam.second, s.stream), s.adam.steps,
                 s.adam.rest_steps};
  s.download_sums();
  s.density.download(s.stream, s.host.density);
  s.field.download(s.stream, s.host.color_field);
  s.codes.download(s.stream, s.host.codes);
  return s.host;
}

const qs::train::GaussianFacts& GpuModel::facts() {
  State& s = gpu();
  const Parameters& p = s.parameters;
  copy_to_host(p.means.data(), s.facts.means, p.count, s.stream);
  copy_to_host(p.log_scales.data(), s.facts.log_scales, p.count, s.stream);
  copy_to_host(p.rotations.data(), s.facts.rotations, p.count, s.stream);
  copy_to_host(p.opacity_logits.data(), s.facts.opacity_logits, p.count, s.stream);
  copy_to_host(p.mask_logits.data(), s.facts.mask_logits, p.has_masks ? p.count : 0, s.stream);
  s.density.download(s.stream, s.facts.density);
  s.counts.download(s.stream, s.facts.counts);
  s.facts.growth = s.host.growth;
  return s.facts;
}

// Everything is gathered before anything is replaced, so it can be gathered again.
void GpuModel::apply(const qs::train::Plan& plan) {
  State& s = gpu();
  s.side.join(s.stream);
  s.with_memory([&] { s.gather_next(plan); });
  if (plan.resets_statistics) std::swap(s.density, s.next.density);
  s.host.changed_before = plan.iteration;
  s.host.growth = plan.growth;
  s.counts.count = 0;
  s.sums.has_rest = s.sums.has_others = false;
  std::swap(s.parameters, s.next.parameters);
  std::swap(s.adam.first, s.next.first);
  std::swap(s.adam.second, s.next.second);
}

void GpuModel::State::gather_next(const qs::train::Plan& plan) {
  const auto count = static_cast<std::uint32_t>(plan.size());
  next.sources.reserve("the model", with_room(count));
  next.moment_sources.reserve("the model", with_room(count));
  copy_to_device(plan.sources.data(), next.sources, count, stream);
  copy_to_device(plan.moment_sources.data(), next.moment_sources, count, stream);
  gather(parameters, next.sources, count, stream, next.parameters);
  gather(adam.first, next.moment_sources, count, stream, next.first);
  gather(adam.second, next.moment_sources, count, stream, next.second);
  copy_to_device(plan.means.data(), next.parameters.means, count, stream);
  copy_to_device(plan.log_scales.data(), next.parameters.log_scales, count, stream);
  copy_to_device(plan.opacity_logits.data(), next.parameters.opacity_logits, count, stream);
  if (plan.clears_opacity_moments && count > 0)
    for (Parameters* moments : {&next.first, &next.second})
      set_zero("clear moments", moments->opacity_logits.data(), count, stream);
  if (plan.resets_statistics) next.density.reset(count, stream);
}

void GpuModel::forward(const Camera& camera, const RenderSettings& settings, std::stop_token stop) {
  State& s = gpu();
  s.camera = camera;
  s.settings = settings;
  s.stop = std::move(stop);
  s.clock.begin(s.stream);
  s.with_memory([&] {
    if (s.codes.exist()) code_shapes(s.parameters.view(), s.codes, s.stream);
    const ParametersView drawn = s.drawn();
    project_view(s.view(), drawn, s.frame);
    s.side.fork(s.stream, [&](cudaStream_t beside) {
      if (s.field.exists())
        FieldPasses{s.view(), drawn, s.field, beside}.color(s.frame);
      else
        color_view(s.view(), drawn, s.frame, beside);
    });
    list_view(s.view(), s.parameters.count, s.frame);
    s.side.join(s.stream);
    draw_view(s.view(), s.frame);
  });
  s.clock.end(0, s.stream);
}

void GpuModel::forget_photographs() { gpu().free_photographs(); }

qs::train::Quality GpuModel::quality(const qs::train::Photograph& photograph) {
  State& s = gpu();
  qs::train::Quality quality;
  s.with_memory([&] {
    const diff::ComparisonSums sums = s.sums_of(s.comparison(std::nullopt, photograph));
    quality = {sums.psnr(), sums.mean_ssim()};
  });
  return quality;
}

void GpuModel::compare_with(std::optional<std::size_t> number,
                            const qs::train::Photograph& photograph) {
  State& s = gpu();
  s.with_memory([&] { s.compare(s.comparison(number, photograph)); });
}

void GpuModel::count_errors(std::optional<std::size_t> number,
                            const qs::train::Photograph& photograph) {
  State& s = gpu();
  s.with_memory([&] {
    train::count_errors(s.view(), s.frame, s.comparison(number, photograph), s.parameters.count,
                        s.errors, s.counts);
  });
}

void GpuModel::compare(std::span<const glm::vec3> target, std::span<const std::uint8_t> mask) {
  State& s = gpu();
  s.copy_pixels(target, s.target);
  if (!mask.empty()) s.copy_pixels(mask, s.mask);
  const auto masked = std::count(mask.begin(), mask.end(), std::uint8_t{0});
  s.compare(s.comparison(mask.empty() ? nullptr : s.mask.data(),
                         s.pixels() - static_cast<std::size_t>(masked)));
}

void GpuModel::backward(const qs::train::BackwardOrder& order) {
  State& s = gpu();
  s.with_memory([&] {
    const ParametersView drawn = s.drawn();
    const bool has_field = s.field.exists();
    train::backward(s.view(), drawn, s.frame, s.d_color.data(), order, s.backward, s.gradients,
                    has_field ? s.field.d_outputs.data() : nullptr);
    const ParametersView by = s.gradients.by.view();
    if (has_field) FieldPasses{s.view(), drawn, s.field, s.stream}.network_gradients(by.means);
    if (s.codes.exist()) pass_through_codes(s.parameters.view(), s.codes, by, s.stream);
    if (has_field)
      s.side.fork(s.stream, [&](cudaStream_t beside) {
        FieldPasses{s.view(), drawn, s.field, beside}.sum_gradients();
      });
  });
  s.clock.end(2, s.stream);
}

void GpuModel::set_pixel_gradients(std::span<const glm::vec3> d_color) {
  State& s = gpu();
  s.copy_pixels(d_color, s.d_color);
}

void GpuModel::step(const qs::train::StepOrder& order) {
  State& s = gpu();
  if (order.counts_density) {
    const diff::GpuGaussianBlock& gaussians = s.frame.listed.gaussians;
    const CountedGaussians counted{gaussians.projected,
                                   order.counts_by_mode ? gaussians.tile_counts : nullptr};
    s.density.add(s.gradients, counted, s.camera.width, s.camera.height, s.stream);
  }
  if (order.sums) {
    s.with_memory([&] {
      s.sums.by.resize(s.parameters.count, s.parameters.sh_degree, s.parameters.has_masks);
    });
    add_gradients(order, s.gradients, s.sums, s.stream);
  }
  const bool uses_sums = order.sums && (!order.moves || s.sums.has_others);
  take_step(order, s.parameters, uses_sums ? s.sums.by : s.gradients.by, s.adam, s.stream);
  if (s.codes.exist()) take_code_steps(s.parameters.view(), s.codes, s.stream);
  if (order.moves || order.sums || s.field.exists())
    s.side.fork(s.stream, [&](cudaStream_t beside) {
      if (order.sums) add_color_gradients(order, s.gradients, s.sums, beside);
      take_color_step(order, s.parameters, s.gradients, s.sums, s.adam, beside);
      if (s.field.exists()) take_field_step(order.field_rate, s.field, beside);
    });
  s.clock.end(3, s.stream);
  s.host.iteration = order.iteration;
}

Loss GpuModel::recent_loss() {
  State& s = gpu();
  assert(s.comparisons > 0);
  const std::uint64_t number = s.comparisons > 1 ? s.comparisons - 2 : 0;
  return s.losses[number % 2].wait();
}

std::optional<qs::train::PassSeconds> GpuModel::pass_seconds() { return gpu().clock.seconds(); }

std::optional<std::uint64_t> GpuModel::gpu_memory_bytes() {
  const std::size_t before = gpu().free_before, free = DeviceMemory::now().free;
  return before > free ? before - free : 0;
}

void GpuModel::wait() const {
  State& s = gpu();
  s.side.join(s.stream);
  check(cudaStreamSynchronize(s.stream), "training");
}

Loss GpuModel::loss() const {
  State& s = gpu();
  assert(s.comparisons > 0);
  return s.losses[(s.comparisons - 1) % 2].wait();
}

PixelCopies GpuModel::pixels() const {
  State& s = gpu();
  return {copied(s.frame.pixels.colors(), s.pixels(), s.stream),
          copied(s.frame.pixels.transmittance, s.pixels(), s.stream),
          copied(s.frame.pixels.last, s.pixels(), s.stream)};
}

std::vector<glm::vec3> GpuModel::pixel_gradients() const {
  State& s = gpu();
  return copied(s.d_color.data(), s.pixels(), s.stream);
}

GradientCopies GpuModel::gradients() const {
  State& s = gpu();
  expand_colors(s.parameters.sh_degree, s.stream, s.gradients);
  return {download(s.gradients.by, s.stream),
          copied(s.gradients.mean_px.data(), s.parameters.count, s.stream),
          copied(s.gradients.absolute_px.data(), s.gradients.has_absolute ? s.parameters.count : 0,
                 s.stream),
          copied(s.frame.listed.gaussians.projected, s.parameters.count, s.stream)};
}

FieldGradientCopies GpuModel::field_gradients() const {
  State& s = gpu();
  s.side.join(s.stream);
  FieldGradientCopies copies;
  for (const unsigned long long sum :
       copied(s.field.grid_sums.data(), s.field.grid_count, s.stream))
    copies.grid.push_back(static_cast<double>(static_cast<long long>(sum)) * kSumUnit);
  copies.weights = copied(s.field.by_weights.data(), s.field.weight_count, s.stream);
  return copies;
}

std::uint32_t GpuModel::pairs() const { return state_->frame.pairs; }

}  // namespace qs::cuda::train
