// SPDX-License-Identifier: MIT
#include <algorithm>

#include "raster/cuda/fast/radix_sort.cuh"

namespace qs::cuda::fast {
namespace {

using Key32 = std::uint32_t;

constexpr unsigned kCountingBlocks = 132;  // few, because each adds all its bins to the totals

__global__ void __launch_bounds__(kSortThreads)
    count_all_digits(const Key32* keys, std::uint32_t size, std::uint32_t* counts,
                     std::uint32_t* kept) {
  constexpr int kPasses = Radix<Key32>::kPasses, kAtATime = 4;
  constexpr unsigned kCounts = kPasses * kBins<Key32>;
  __shared__ std::uint32_t block_counts[kCounts];
  for (unsigned i = threadIdx.x; i < kCounts; i += kSortThreads) block_counts[i] = 0;
  __syncthreads();
  std::uint32_t mine = 0;
  const std::uint32_t stride = gridDim.x * kSortThreads;
  for (std::uint32_t i = blockIdx.x * kSortThreads + threadIdx.x; i < size;
       i += kAtATime * stride) {
    Key32 own[kAtATime];
#pragma unroll
    for (std::uint32_t k = 0; k < kAtATime; ++k) {
      own[k] = std::uint64_t{i} + k * stride < size ? keys[i + k * stride] : kDroppedKey;
    }
#pragma unroll
    for (const Key32 key : own) {
      if (key == kDroppedKey) continue;
      ++mine;
      for (int pass = 0; pass < kPasses; ++pass) {
        atomicAdd(&block_counts[pass * kBins<Key32> + digit_of(key, pass)], 1u);
      }
    }
  }
  __syncthreads();
  for (unsigned i = threadIdx.x; i < kCounts; i += kSortThreads) {
    if (block_counts[i] > 0) atomicAdd(&counts[i], block_counts[i]);
  }
  const std::uint32_t total = sum_of_block<kSortThreads>(mine).total;
  if (threadIdx.x == 0 && total > 0) atomicAdd(kept, total);
}

/// Publishes `own`, this part's number of items with the digit `bin`, and returns the number of
/// such items in all earlier parts.
__device__ std::uint32_t look_back(volatile std::uint32_t* words, unsigned bins, unsigned bin,
                                   std::uint32_t own) {
  using Word = LookBackWord<std::uint32_t>;
  constexpr int kWindow = 12;  // parts read at a time, to hide memory latency
  const int part = static_cast<int>(blockIdx.x);
  const auto word_of = [&](int p) -> volatile std::uint32_t& {
    return words[static_cast<std::size_t>(p) * bins + bin];
  };
  word_of(part) = (part == 0 ? Word::kUpTo : Word::kOwn) | own;
  std::uint32_t before = 0;
  bool complete = part == 0;
  for (int nearest = part - 1; !complete;) {
    std::uint32_t seen[kWindow];
#pragma unroll
    for (int w = 0; w < kWindow; ++w) {
      seen[w] = 0;
      if (nearest >= w) seen[w] = word_of(nearest - w);
    }
#pragma unroll
    for (int w = 0; w < kWindow; ++w) {
      if (complete || seen[w] == 0) break;
      before += seen[w] & Word::kValue;
      complete = (seen[w] & Word::kUpTo) != 0;
      --nearest;
    }
  }
  if (part > 0) word_of(part) = Word::kUpTo | (before + own);
  return before;
}

constexpr unsigned kSortBlocks = 3;  // per multiprocessor, to hide latency

template <class Key>
__global__ void __launch_bounds__(kSortThreads, kSortBlocks) sort_digit(SortPass<Key> pass) {
  constexpr int kItems = kPart / kSortThreads;
  constexpr unsigned kAllBins = kBins<Key>, kWarps = kSortThreads / kWarp;
  static_assert(kAllBins <= kSortThreads);
  __shared__ std::uint16_t counts[kWarps][kAllBins];  // later: items of lower warps
  __shared__ std::uint32_t begin[kAllBins];           // of a digit in the sorted part
  __shared__ std::uint32_t target[kAllBins];          // destination minus index in the part
  __shared__ std::uint32_t exchange[kPart];           // the part's sorted keys, then values
  const std::uint32_t size = pass.count.get(), first = blockIdx.x * kPart;
  if (first >= size) return;
  const unsigned thread = threadIdx.x, warp = thread / kWarp, lane = lane_index();

  for (unsigned i = lane; i < kAllBins; i += kWarp) counts[warp][i] = 0;
  __syncwarp();
  const auto item = [&](int j) { return first + (warp * kItems + j) * kWarp + lane; };
  Key keys[kItems];
  unsigned valid = 0;  // bit per item
#pragma unroll
  for (int j = 0; j < kItems; ++j) {
    keys[j] = 0;
    if (item(j) >= size) continue;
    keys[j] = pass.keys[item(j)];
    if (!pass.drops || keys[j] != static_cast<Key>(kDroppedKey)) valid |= 1u << j;
  }

  // Rank every item among the warp's items with the same digit, in order.
  std::uint16_t places[kItems];
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
    places[j] = static_cast<std::uint16_t>(earlier + below);
  }
  __syncthreads();

  // One thread per bin turns counts into offsets.
  std::uint64_t own = 0;  // upper half: items in the whole input, lower half: in the part
  std::uint32_t before = 0;
  if (thread < kAllBins) {
    std::uint32_t sum = 0;
#pragma unroll
    for (unsigned w = 0; w < kWarps; ++w) {
      const std::uint32_t count = counts[w][thread];
      counts[w][thread] = static_cast<std::uint16_t>(sum);
      sum += count;
    }
    own = std::uint64_t{pass.digit_counts[thread]} << 32 | sum;
    before = look_back(pass.words, kAllBins, thread, sum);
  }
  const BlockSum<std::uint64_t> block = sum_of_block<kSortThreads>(own);
  if (thread < kAllBins) {
    begin[thread] = static_cast<std::uint32_t>(block.before);
    target[thread] = static_cast<std::uint32_t>(block.before >> 32) + before - begin[thread];
  }
  __syncthreads();

  // Sort the part in shared memory, so that global writes are coalesced.
#pragma unroll
  for (int j = 0; j < kItems; ++j) {
    if ((valid >> j & 1) == 0) continue;
    const std::uint32_t digit = digit_of(keys[j], pass.pass);
    places[j] = static_cast<std::uint16_t>(places[j] + begin[digit] + counts[warp][digit]);
    exchange[places[j]] = keys[j];
  }
  __syncthreads();
  const auto kept = static_cast<std::uint32_t>(block.total);
  std::uint32_t to[kItems];
#pragma unroll
  for (int j = 0; j < kItems; ++j) {
    const std::uint32_t i = thread + j * kSortThreads;
    if (i >= kept) break;
    const Key key = static_cast<Key>(exchange[i]);
    to[j] = target[digit_of(key, pass.pass)] + i;
    if (pass.sorted_keys != nullptr) pass.sorted_keys[to[j]] = key;
    if (pass.ranges != nullptr) {
      // The lower digits are sorted already, so equal keys are adjacent here.
      if (i == 0 || exchange[i - 1] != key) atomicMax(&pass.ranges[key].not_begin, ~to[j]);
      if (i + 1 == kept || exchange[i + 1] != key) atomicMax(&pass.ranges[key].end, to[j] + 1);
    }
  }
  __syncthreads();
#pragma unroll
  for (int j = 0; j < kItems; ++j) {
    if ((valid >> j & 1) == 0) continue;
    exchange[places[j]] = pass.values != nullptr ? pass.values[item(j)] : item(j);
  }
  __syncthreads();
#pragma unroll
  for (int j = 0; j < kItems; ++j) {
    const std::uint32_t i = thread + j * kSortThreads;
    if (i < kept) pass.sorted_values[to[j]] = exchange[i];
  }
}

}  // namespace

void count_digits(const std::uint32_t* keys, std::uint32_t size, std::uint32_t* counts,
                  std::uint32_t* kept, cudaStream_t stream) {
  const unsigned blocks = std::clamp(blocks_for(size), 1u, kCountingBlocks);
  launch("sort", count_all_digits, Blocks(blocks, kSortThreads), stream, keys, size, counts, kept);
}

template <class Key>
void sort_pass(const SortPass<Key>& pass, cudaStream_t stream) {
  launch("sort", sort_digit<Key>, Blocks(pass.count.parts(), kSortThreads), stream, pass);
}

template void sort_pass(const SortPass<std::uint16_t>&, cudaStream_t);
template void sort_pass(const SortPass<std::uint32_t>&, cudaStream_t);

}  // namespace qs::cuda::fast
