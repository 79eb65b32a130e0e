// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cassert>

#include <hwy/aligned_allocator.h>

#include "raster/field/field_evaluator.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "raster/field/field_vectors.cpp"
#include "base/simd.h"

HWY_BEFORE_NAMESPACE();
namespace qs::field_vectors {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<float, 16>;
using U = hn::RebindToUnsigned<D>;
using I = hn::RebindToSigned<D>;
using V = hn::Vec<D>;

// Vectors that pass a layer together, and outputs whose sums are in registers.
constexpr std::size_t kVectors = 3;
#if HWY_TARGET <= HWY_AVX3  // 32 registers
constexpr std::size_t kSums = kRows;
#else
constexpr std::size_t kSums = kRows / 2;
#endif
static_assert(kDesignSize % kVectors == 0);

/// Adds a matrix times `kCount` columns of inputs to `y`, which has the sums so far. x: (inputs,
/// kCount, lanes), y: (outputs, kCount, lanes). `kBlock` is the matrix's number of rows per block.
template <std::size_t kCount, std::size_t kBlock>
HWY_INLINE void multiply(const float* matrix, std::size_t outputs, std::size_t inputs,
                         const float* x, float* y) {
  const D d;
  const std::size_t step = kCount * hn::Lanes(d);
  constexpr std::size_t kTogether = kSums < kBlock ? kSums : kBlock;
  for (std::size_t row = 0; row < outputs; row += kTogether) {
    const float* weights = matrix + row / kBlock * kBlock * inputs + row % kBlock;
    V sum[kTogether][kCount];
    for (std::size_t r = 0; r < kTogether; ++r)
      for (std::size_t v = 0; v < kCount; ++v)
        sum[r][v] = hn::Load(d, y + (row + r) * step + v * hn::Lanes(d));
    const float* in = x;
    for (std::size_t k = 0; k < inputs; ++k, in += step, weights += kBlock) {
      V value[kCount];
      for (std::size_t v = 0; v < kCount; ++v) value[v] = hn::Load(d, in + v * hn::Lanes(d));
      for (std::size_t r = 0; r < kTogether; ++r) {
        const V weight = hn::Set(d, weights[r]);
        for (std::size_t v = 0; v < kCount; ++v)
          sum[r][v] = hn::MulAdd(weight, value[v], sum[r][v]);
      }
    }
    for (std::size_t r = 0; r < kTogether; ++r)
      for (std::size_t v = 0; v < kCount; ++v)
        hn::Store(sum[r][v], d, y + (row + r) * step + v * hn::Lanes(d));
  }
}

HWY_INLINE void relu(float* values, std::size_t count) {
  const D d;
  for (std::size_t i = 0; i < count; i += hn::Lanes(d))
    hn::Store(hn::Max(hn::Load(d, values + i), hn::Zero(d)), d, values + i);
}

/// A vector of positions.
struct Points {
  V x, y, z;
};

/// The means [begin, begin + lanes); the last one is repeated behind the end.
HWY_INLINE Points load_points(std::span<const glm::vec3> means, std::size_t begin) {
  const D d;
  HWY_ALIGN float x[16], y[16], z[16];
  for (std::size_t lane = 0; lane < hn::Lanes(d); ++lane) {
    const glm::vec3& mean = means[std::min(begin + lane, means.size() - 1)];
    x[lane] = mean.x;
    y[lane] = mean.y;
    z[lane] = mean.z;
  }
  return {hn::Load(d, x), hn::Load(d, y), hn::Load(d, z)};
}

HWY_INLINE V length_of(const Points& p) {
  return hn::Sqrt(hn::MulAdd(p.x, p.x, hn::MulAdd(p.y, p.y, hn::Mul(p.z, p.z))));
}

/// contract() of kernel/color_field.h. Positions without a place, such as infinite ones, get 0.
HWY_INLINE Points contracted(const Points& mean) {
  const D d;
  const V one = hn::Set(d, 1.0f), length = length_of(mean);
  const V outside = hn::Div(hn::Sub(hn::Set(d, 2.0f), hn::Div(one, length)), length);
  const V factor = hn::Mul(hn::IfThenElse(hn::Le(length, one), one, outside), hn::Set(d, 0.25f));
  const auto place = [&](V value) HWY_ATTR {
    const V moved = hn::MulAdd(value, factor, hn::Set(d, 0.5f));
    const auto inside = hn::And(hn::Ge(moved, hn::Zero(d)), hn::Le(moved, one));
    return hn::IfThenElseZero(inside, moved);
  };
  return {place(mean.x), place(mean.y), place(mean.z)};
}

/// grid_entry() of kernel/color_field.h. An index of a dense level is below twice its entries.
HWY_INLINE hn::Vec<U> entries_of(const GridLevel& level, hn::Vec<U> x, hn::Vec<U> y, hn::Vec<U> z) {
  const U u;
  const auto entries = hn::Set(u, level.entries);
  if (level.is_dense) {
    const auto side = hn::Set(u, level.resolution);
    const auto index = hn::Add(x, hn::Mul(side, hn::Add(y, hn::Mul(side, z))));
    return hn::Min(index, hn::Sub(index, entries));  // wraps around if it is below
  }
  const auto hash =
      hn::Xor(x, hn::Xor(hn::Mul(y, hn::Set(u, 2654435761u)), hn::Mul(z, hn::Set(u, 805459861u))));
  return hn::And(hash, hn::Sub(entries, hn::Set(u, 1u)));
}

HWY_INLINE V half_below(hn::Vec<U> pair) {
  const D d;
  const hn::Rebind<std::uint16_t, D> du;
  const hn::Rebind<hwy::float16_t, D> dh;
  return hn::PromoteTo(d, hn::BitCast(dh, hn::TruncateTo(du, pair)));
}

/// The features of a vector of means, (levels * kGridFeatures, kCount, lanes) of which this is
/// vector 0.
template <std::size_t kCount>
HWY_INLINE void encode(const Packed& packed, const Points& means, float* features) {
  const D d;
  const U u;
  const I i;
  const Points position = contracted(means);
  const V half = hn::Set(d, 0.5f), one = hn::Set(d, 1.0f);
  const std::size_t step = kCount * hn::Lanes(d);
  for (const GridLevel& level : packed.levels) {
    const V scale = hn::Set(d, level.scale);
    const V px = hn::MulAdd(scale, position.x, half), py = hn::MulAdd(scale, position.y, half),
            pz = hn::MulAdd(scale, position.z, half);
    const V cx = hn::Floor(px), cy = hn::Floor(py), cz = hn::Floor(pz);
    const V fx = hn::Sub(px, cx), fy = hn::Sub(py, cy), fz = hn::Sub(pz, cz);
    const auto x = hn::BitCast(u, hn::ConvertTo(i, cx)), y = hn::BitCast(u, hn::ConvertTo(i, cy)),
               z = hn::BitCast(u, hn::ConvertTo(i, cz));
    const V gx = hn::Sub(one, fx), gy = hn::Sub(one, fy), gz = hn::Sub(one, fz);
    const auto* const entries = reinterpret_cast<const std::int32_t*>(packed.entries.data());
    V first = hn::Zero(d), second = hn::Zero(d);
    for (unsigned corner = 0; corner < 8; ++corner) {
      const bool right = (corner & 1) != 0, below = (corner & 2) != 0, behind = (corner & 4) != 0;
      const auto next = hn::Set(u, 1u);
      const auto entry = entries_of(level, right ? hn::Add(x, next) : x,
                                    below ? hn::Add(y, next) : y, behind ? hn::Add(z, next) : z);
      const auto index =
          hn::BitCast(i, hn::Add(entry, hn::Set(u, static_cast<std::uint32_t>(level.first))));
      const auto pair = hn::BitCast(u, hn::GatherIndex(i, entries, index));
      const V weight = hn::Mul(hn::Mul(right ? fx : gx, below ? fy : gy), behind ? fz : gz);
      first = hn::MulAdd(weight, half_below(pair), first);
      second = hn::MulAdd(weight, half_below(hn::ShiftRight<16>(pair)), second);
    }
    hn::Store(first, d, features);
    hn::Store(second, d, features + step);
    features += 2 * step;
  }
}

/// encode_direction() of kernel/color_field.h.
HWY_INLINE void encode_directions(const Points& direction, float* features) {
  const D d;
  const auto c = [d](double value) HWY_ATTR { return hn::Set(d, static_cast<float>(value)); };
  const auto moved = [&](V value) HWY_ATTR { return hn::Sub(hn::Add(value, value), c(1)); };
  const V x = moved(direction.x), y = moved(direction.y), z = moved(direction.z);
  const V values[kDirectionFeatures] = {c(kSh0),
                                        hn::Mul(c(-kSh1), y),
                                        hn::Mul(c(kSh1), z),
                                        hn::Mul(c(-kSh1), x),
                                        hn::Mul(c(kSh2A), hn::Mul(x, y)),
                                        hn::Mul(c(-kSh2A), hn::Mul(y, z)),
                                        hn::MulAdd(c(3 * kSh2B), hn::Mul(z, z), c(-kSh2B)),
                                        hn::Mul(c(-kSh2A), hn::Mul(x, z)),
                                        hn::Mul(c(kSh2C), hn::Sub(hn::Mul(x, x), hn::Mul(y, y)))};
  for (std::size_t k = 0; k < kDirectionFeatures; ++k)
    hn::Store(values[k], d, features + k * kVectors * hn::Lanes(d));
}

/// The second and the third layer, from the outputs of the first layer.
HWY_INLINE void pass_layers(const Packed& packed, const float* first, float* second, float* last) {
  const std::size_t width = packed.width, step = kVectors * hn::Lanes(D());
  std::fill_n(second, width * step, 0.0f);
  multiply<kVectors, kRows>(packed.hidden.data(), width, width, first, second);
  relu(second, width * step);
  std::fill_n(last, kOutRows * step, 0.0f);
  multiply<kVectors, kOutRows>(packed.last.data(), kOutRows, width, second, last);
}

using Buffer = hwy::AlignedFreeUniquePtr<float[]>;

Buffer buffer(std::size_t values) { return hwy::AllocateAligned<float>(values); }

/// Fills (rows, kVectors, lanes) values with a value per row.
HWY_INLINE void spread(const float* values, std::size_t rows, float* out) {
  const D d;
  for (std::size_t row = 0; row < rows; ++row)
    for (std::size_t v = 0; v < kVectors; ++v, out += hn::Lanes(d))
      hn::Store(hn::Set(d, values[row]), d, out);
}

/// Outputs of the network for each mean seen from `eye`.
void outputs_of(const Packed& packed, std::span<const glm::vec3> means, const glm::vec3& eye,
                glm::vec3* out) {
  if (means.empty()) return;
  const D d;
  const std::size_t lanes = hn::Lanes(d), step = kVectors * lanes, width = packed.width;
  const std::size_t inputs = packed.levels.size() * kGridFeatures;
  const Buffer features = buffer((inputs + kDirectionFeatures) * step);
  const Buffer first = buffer(width * step), second = buffer(width * step),
               last = buffer(kOutRows * step);
  float* const directions = features.get() + inputs * step;
  for (std::size_t begin = 0; begin < means.size(); begin += step) {
    for (std::size_t v = 0; v < kVectors; ++v) {
      const Points mean = load_points(means, begin + v * lanes);
      encode<kVectors>(packed, mean, features.get() + v * lanes);
      const Points offset = {hn::Sub(mean.x, hn::Set(d, eye.x)), hn::Sub(mean.y, hn::Set(d, eye.y)),
                             hn::Sub(mean.z, hn::Set(d, eye.z))};
      const V scale = hn::Div(hn::Set(d, 1.0f), length_of(offset));
      encode_directions(
          {hn::Mul(offset.x, scale), hn::Mul(offset.y, scale), hn::Mul(offset.z, scale)},
          directions + v * lanes);
    }
    spread(packed.bias.data(), width, first.get());
    multiply<kVectors, kRows>(packed.from_grid.data(), width, inputs, features.get(), first.get());
    multiply<kVectors, kRows>(packed.from_direction.data(), width, kDirectionFeatures, directions,
                              first.get());
    relu(first.get(), width * step);
    pass_layers(packed, first.get(), second.get(), last.get());
    const std::size_t count = std::min(step, means.size() - begin);
    for (std::size_t i = 0; i < count; ++i)
      out[begin + i] = {last[i], last[step + i], last[2 * step + i]};
  }
}

/// Outputs of a vector of means in all design directions: (kDesignSize, 3, lanes) values.
class DesignOutputs {
 public:
  explicit DesignOutputs(const Packed& packed) : packed_(packed) {}

  const float* get() const { return all_.get(); }

  HWY_INLINE void compute(const Points& means) {
    const D d;
    const std::size_t lanes = hn::Lanes(d), step = kVectors * lanes, width = packed_.width;
    encode<1>(packed_, means, features_.get());
    std::fill_n(base_.get(), width * lanes, 0.0f);
    multiply<1, kRows>(packed_.from_grid.data(), width, inputs_, features_.get(), base_.get());
    float* all = all_.get();
    for (std::size_t direction = 0; direction < kDesignSize; direction += kVectors) {
      const float* const parts = packed_.of_design.data() + direction * width;
      for (std::size_t row = 0; row < width; ++row) {
        const V base = hn::Load(d, base_.get() + row * lanes);
        for (std::size_t v = 0; v < kVectors; ++v) {
          const V sum = hn::Add(base, hn::Set(d, parts[v * width + row]));
          hn::Store(hn::Max(sum, hn::Zero(d)), d, first_.get() + row * step + v * lanes);
        }
      }
      pass_layers(packed_, first_.get(), second_.get(), last_.get());
      for (std::size_t v = 0; v < kVectors; ++v)
        for (std::size_t channel = 0; channel < 3; ++channel, all += lanes)
          hn::Store(hn::Load(d, last_.get() + channel * step + v * lanes), d, all);
    }
  }

 private:
  const Packed& packed_;
  std::size_t lanes_ = hn::Lanes(D()), step_ = kVectors * lanes_;
  std::size_t inputs_ = packed_.levels.size() * kGridFeatures;
  Buffer features_ = buffer(inputs_ * lanes_), base_ = buffer(packed_.width * lanes_);
  Buffer first_ = buffer(packed_.width * step_), second_ = buffer(packed_.width * step_);
  Buffer last_ = buffer(kOutRows * step_), all_ = buffer(kDesignSize * 3 * lanes_);
};

/// SH coefficients of degree 3, 16 per mean, and the rms difference of each mean's colour values.
void fit_of(const Packed& packed, std::span<const glm::vec3> means, glm::vec3* sh, float* rms) {
  if (means.empty()) return;
  const D d;
  const std::size_t lanes = hn::Lanes(d);
  DesignOutputs outputs(packed);
  const Buffer fitted = buffer(16 * 3 * lanes);
  HWY_ALIGN float differences[16];
  const V to_color = hn::Set(d, static_cast<float>(kSh0));
  for (std::size_t begin = 0; begin < means.size(); begin += lanes) {
    outputs.compute(load_points(means, begin));
    for (std::size_t i = 0; i < 16; ++i) {
      V sum[3] = {hn::Zero(d), hn::Zero(d), hn::Zero(d)};
      const float* value = outputs.get();
      for (std::size_t j = 0; j < kDesignSize; ++j) {
        const V weight = hn::Set(d, packed.design.weights[j][i]);
        for (V& channel : sum) {
          channel = hn::MulAdd(weight, hn::Load(d, value), channel);
          value += lanes;
        }
      }
      for (std::size_t channel = 0; channel < 3; ++channel)
        hn::Store(hn::Mul(sum[channel], to_color), d, fitted.get() + (3 * i + channel) * lanes);
    }
    V squares = hn::Zero(d);
    const float* value = outputs.get();
    for (std::size_t j = 0; j < kDesignSize; ++j) {
      for (std::size_t channel = 0; channel < 3; ++channel, value += lanes) {
        V difference = hn::Mul(hn::Load(d, value), to_color);
        for (std::size_t i = 0; i < 16; ++i)
          difference =
              hn::NegMulAdd(hn::Set(d, packed.design.basis[j][i]),
                            hn::Load(d, fitted.get() + (3 * i + channel) * lanes), difference);
        squares = hn::MulAdd(difference, difference, squares);
      }
    }
    hn::Store(hn::Sqrt(hn::Mul(squares, hn::Set(d, 1.0f / (3 * kDesignSize)))), d, differences);
    const std::size_t count = std::min(lanes, means.size() - begin);
    for (std::size_t lane = 0; lane < count; ++lane) {
      rms[begin + lane] = differences[lane];
      for (std::size_t i = 0; i < 16; ++i) {
        const float* const at = fitted.get() + 3 * i * lanes + lane;
        sh[(begin + lane) * 16 + i] = {at[0], at[lanes], at[2 * lanes]};
      }
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace qs::field_vectors
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace qs {
namespace field_vectors {
HWY_EXPORT(outputs_of);
HWY_EXPORT(fit_of);
}  // namespace field_vectors

void FieldEvaluator::outputs(std::span<const glm::vec3> means, const glm::vec3& eye,
                             std::span<glm::vec3> out) const {
  assert(out.size() == means.size());
  using namespace field_vectors;
  HWY_DYNAMIC_DISPATCH(outputs_of)(packed_, means, eye, out.data());
}

void FieldEvaluator::fit_sh(std::span<const glm::vec3> means, std::span<glm::vec3> sh,
                            std::span<float> rms) const {
  assert(sh.size() == 16 * means.size() && rms.size() == means.size());
  using namespace field_vectors;
  HWY_DYNAMIC_DISPATCH(fit_of)(packed_, means, sh.data(), rms.data());
}

}  // namespace qs
#endif
