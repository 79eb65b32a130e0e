// SPDX-License-Identifier: MIT
#include <algorithm>

#include "raster/cuda/fast/radix_sort.cuh"

namespace qs::cuda::fast {
namespace {

using Key32 = std::uint32_t;

constexpr unsigned kCountingBlocks = 96;  // few: each adds all its bins to the totals

__global__ void __launch_bounds__(kThreads)
    count_all_digits(const Key32* keys, std::uint32_t size, std::uint32_t* counts,
                     std::uint32_t* kept) {
  constexpr int kPasses = Radix<Key32>::kPasses;
  constexpr unsigned kCounts = kPasses * kBins<Key32>;
  __shared__ std::uint32_t block_counts[kCounts];
  for (unsigned i = threadIdx.x; i < kCounts; i += kThreads) block_counts[i] = 0;
  __syncthreads();
  std::uint32_t mine = 0;
  for (std::uint32_t i = blockIdx.x * kThreads + threadIdx.x; i < size; i += gridDim.x * kThreads) {
    const Key32 key = keys[i];
    if (key == kDroppedKey) continue;
    ++mine;
    for (int pass = 0; pass < kPasses; ++pass) {
      atomicAdd(&block_counts[pass * kBins<Key32> + digit_of(key, pass)], 1u);
    }
  }
  __syncthreads();
  for (unsigned i = threadIdx.x; i < kCounts; i += kThreads) {
    if (block_counts[i] > 0) atomicAdd(&counts[i], block_counts[i]);
  }
  const std::uint32_t total = sum_of_block(mine).total;
  if (threadIdx.x == 0 && total > 0) atomicAdd(kept, total);
}

/// The lanes whose item is valid and has this lane's digit.
template <int kBits>
__device__ unsigned peers_of(std::uint32_t digit, bool valid) {
  unsigned peers = __ballot_sync(kAllLanes, valid);
#pragma unroll
  for (int bit = 0; bit < kBits; ++bit) {
    const bool set = (digit >> bit & 1) != 0;
    const unsigned with = __ballot_sync(kAllLanes, set);
    peers &= set ? with : ~with;
  }
  return peers;
}

/// For each of a thread's kOwn neighbouring bins, how many items with that digit earlier parts
/// have.
template <unsigned kAllBins, unsigned kOwn>
__device__ void look_back(volatile std::uint32_t* words, unsigned first_bin,
                          const std::uint32_t (&own)[kOwn], std::uint32_t (&before)[kOwn]) {
  using Word = LookBackWord<std::uint32_t>;
  constexpr int kWindow = 4;  // parts read at a time, to wait for memory less often
  const int part = static_cast<int>(blockIdx.x);
  const auto word_of = [&](int p, unsigned k) -> volatile std::uint32_t& {
    return words[static_cast<std::size_t>(p) * kAllBins + first_bin + k];
  };
#pragma unroll
  for (unsigned k = 0; k < kOwn; ++k) {
    word_of(part, k) = (part == 0 ? Word::kUpTo : Word::kOwn) | own[k];
    before[k] = 0;
  }
  unsigned open = part == 0 ? 0 : (1u << kOwn) - 1;  // bins that are not complete
  for (int nearest = part - 1; open != 0;) {
    std::uint32_t seen[kWindow][kOwn];
#pragma unroll
    for (int w = 0; w < kWindow; ++w) {
#pragma unroll
      for (unsigned k = 0; k < kOwn; ++k) {
        seen[w][k] = Word::kUpTo;
        if (nearest - w >= 0) seen[w][k] = word_of(nearest - w, k);
      }
    }
    bool told = true;
#pragma unroll
    for (int w = 0; w < kWindow; ++w) {
#pragma unroll
      for (unsigned k = 0; k < kOwn; ++k) told = told && (seen[w][k] != 0 || (open >> k & 1) == 0);
      if (!told) continue;
#pragma unroll
      for (unsigned k = 0; k < kOwn; ++k) {
        if ((open >> k & 1) == 0) continue;
        before[k] += seen[w][k] & Word::kValue;
        if ((seen[w][k] & Word::kUpTo) != 0) open &= ~(1u << k);
      }
      --nearest;
    }
  }
#pragma unroll
  for (unsigned k = 0; k < kOwn; ++k) {
    if (part > 0) word_of(part, k) = Word::kUpTo | (before[k] + own[k]);
  }
}

template <class Key>
__global__ void __launch_bounds__(kThreads) sort_digit(SortPass<Key> pass) {
  constexpr int kItems = Radix<Key>::kItems;
  constexpr unsigned kAllBins = kBins<Key>, kOwnBins = kAllBins / kThreads;
  __shared__ std::uint16_t counts[kWarps][kAllBins];  // then: items of lower warps
  __shared__ std::uint32_t begin[kAllBins];           // of a digit among the part's sorted items
  __shared__ std::uint32_t target[kAllBins];          // where they go, less their place in the part
  __shared__ Key part_keys[kPart<Key>];
  __shared__ std::uint32_t part_values[kPart<Key>];
  const std::uint32_t size = pass.count.get(), first = blockIdx.x * kPart<Key>;
  if (first >= size) return;
  const unsigned thread = threadIdx.x, warp = thread / kWarp, lane = lane_index();

  for (unsigned bin = thread; bin < kAllBins; bin += kThreads) {
    for (unsigned w = 0; w < kWarps; ++w) counts[w][bin] = 0;
  }
  Key keys[kItems];
  std::uint32_t values[kItems];
  unsigned valid = 0;  // bit per item
#pragma unroll
  for (int j = 0; j < kItems; ++j) {
    const std::uint32_t i = first + (warp * kItems + j) * kWarp + lane;
    keys[j] = 0;
    values[j] = i;
    if (i >= size) continue;
    keys[j] = pass.keys[i];
    if (pass.drops && keys[j] == static_cast<Key>(kDroppedKey)) continue;
    if (pass.values != nullptr) values[j] = pass.values[i];
    valid |= 1u << j;
  }
  __syncthreads();

  // Rank every item among the warp's items of its digit, in order.
  std::uint16_t ranks[kItems];
#pragma unroll
  for (int j = 0; j < kItems; ++j) {
    const std::uint32_t digit = digit_of(keys[j], pass.pass);
    const bool is_valid = (valid >> j & 1) != 0;
    const unsigned peers = peers_of<Radix<Key>::kBits>(digit, is_valid);
    const unsigned earlier = counts[warp][digit];
    const int below = __popc(peers & lanes_below());
    __syncwarp();
    if (is_valid && below == 0) {
      counts[warp][digit] = static_cast<std::uint16_t>(earlier + __popc(peers));
    }
    __syncwarp();
    ranks[j] = static_cast<std::uint16_t>(earlier + below);
  }
  __syncthreads();

  // Every thread turns the counts of its bins into places.
  const unsigned first_bin = thread * kOwnBins;
  std::uint32_t own[kOwnBins], before[kOwnBins];
  std::uint64_t sums = 0;  // upper half: items of the whole input, lower half: of the part
#pragma unroll
  for (unsigned k = 0; k < kOwnBins; ++k) {
    std::uint32_t sum = 0;
    for (unsigned w = 0; w < kWarps; ++w) {
      const std::uint32_t count = counts[w][first_bin + k];
      counts[w][first_bin + k] = static_cast<std::uint16_t>(sum);
      sum += count;
    }
    own[k] = sum;
    sums += std::uint64_t{pass.digit_counts[first_bin + k]} << 32 | sum;
  }
  look_back<kAllBins>(pass.words, first_bin, own, before);
  const BlockSum<std::uint64_t> block = sum_of_block(sums);
  auto begin_here = static_cast<std::uint32_t>(block.before);
  auto begin_in_all = static_cast<std::uint32_t>(block.before >> 32);
#pragma unroll
  for (unsigned k = 0; k < kOwnBins; ++k) {
    begin[first_bin + k] = begin_here;
    target[first_bin + k] = begin_in_all + before[k] - begin_here;
    begin_here += own[k];
    begin_in_all += pass.digit_counts[first_bin + k];
  }
  __syncthreads();

  // Sort the part in shared memory, so that neighbours are written by neighbours.
#pragma unroll
  for (int j = 0; j < kItems; ++j) {
    if ((valid >> j & 1) == 0) continue;
    const std::uint32_t digit = digit_of(keys[j], pass.pass);
    const std::uint32_t place = begin[digit] + counts[warp][digit] + ranks[j];
    part_keys[place] = keys[j];
    part_values[place] = values[j];
  }
  __syncthreads();
  const auto kept = static_cast<std::uint32_t>(block.total);
  for (std::uint32_t i = thread; i < kept; i += kThreads) {
    const Key key = part_keys[i];
    const std::uint32_t to = target[digit_of(key, pass.pass)] + i;
    if (pass.sorted_keys != nullptr) pass.sorted_keys[to] = key;
    pass.sorted_values[to] = part_values[i];
  }
}

}  // namespace

void count_digits(const std::uint32_t* keys, std::uint32_t size, std::uint32_t* counts,
                  std::uint32_t* kept, cudaStream_t stream) {
  const unsigned blocks = std::clamp(blocks_for(size), 1u, kCountingBlocks);
  launch("sort", count_all_digits, blocks, stream, keys, size, counts, kept);
}

template <class Key>
void sort_pass(const SortPass<Key>& pass, cudaStream_t stream) {
  launch("sort", sort_digit<Key>, pass.count.template parts<Key>(), stream, pass);
}

template void sort_pass(const SortPass<std::uint16_t>&, cudaStream_t);
template void sort_pass(const SortPass<std::uint32_t>&, cudaStream_t);

}  // namespace qs::cuda::fast
