// SPDX-License-Identifier: MIT
//
// Sums over the threads of a warp and of a block, and other exchanges between lanes.
#pragma once

#include <bit>
#include <cstdint>

#include "raster/cuda/common/check.cuh"

namespace qs::cuda {

inline constexpr unsigned kWarp = 32;
inline constexpr unsigned kAllLanes = 0xffffffffu;

__device__ inline unsigned lane_index() { return threadIdx.x % kWarp; }
__device__ inline unsigned lanes_below() { return (1u << lane_index()) - 1; }

/// Index of the lowest bit that is set.
__device__ inline unsigned lowest_bit(unsigned bits) {
  return static_cast<unsigned>(__ffs(static_cast<int>(bits))) - 1;
}

/// The value, in a register. Without this, compilers compute a value of few instructions again in
/// every turn of a loop.
__device__ inline unsigned kept(unsigned value) {
#ifdef __CUDA_ARCH__
  asm volatile("" : "+r"(value));
#endif
  return value;
}

/// Reads a value that another block of the same launch may have written: from the L2 cache, which
/// all multiprocessors share. Compilers do not move later reads before it, and read again in every
/// turn of a loop (__ldcg() would let ptxas read once).
template <class T>
__device__ T load_fresh(const T* value) {
#ifdef __CUDA_ARCH__
  static_assert(sizeof(T) == sizeof(std::uint32_t));
  std::uint32_t bits;
  asm volatile("ld.relaxed.gpu.global.u32 %0, [%1];" : "=r"(bits) : "l"(value) : "memory");
  return std::bit_cast<T>(bits);
#else
  return *value;
#endif
}

/// Sets a flag that load_fresh() reads, after all that the warp has written before __syncwarp().
/// Unlike __threadfence(), it does not empty the L1 cache.
__device__ inline void publish(std::uint32_t* flag, std::uint32_t value) {
#ifdef __CUDA_ARCH__
  asm volatile("st.release.gpu.global.u32 [%0], %1;" ::"l"(flag), "r"(value) : "memory");
#else
  *flag = value;
#endif
}

/// True for the last of `count` warps that call it with the same counter, which begins at 0. That
/// warp may read with load_fresh() what the others have written. All lanes call it together.
__device__ inline bool is_last_warp(std::uint32_t* counter, std::uint32_t count) {
  std::uint32_t before = 0;
  __syncwarp();
  if (lane_index() == 0) {
#ifdef __CUDA_ARCH__
    asm volatile("atom.add.acq_rel.gpu.global.u32 %0, [%1], 1;"
                 : "=r"(before)
                 : "l"(counter)
                 : "memory");
#else
    before = atomicAdd(counter, 1u);
#endif
  }
  return __shfl_sync(kAllLanes, before, 0) + 1 == count;
}

/// True in the last block of a launch that calls it, which then reads with load_fresh() what the
/// others have written. *done begins at 0. All threads of a block must call it.
__device__ inline bool is_last_block(std::uint32_t* done) {
  __shared__ bool is_last;
  __syncthreads();
  if (threadIdx.x == 0) {
    __threadfence();
    is_last = atomicAdd(done, 1u) + 1 == gridDim.x;
  }
  __syncthreads();
  return is_last;
}

/// Mask of the lanes whose item is valid and has the same digit of `kBits` bits as this lane's.
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

/// Consecutive places for the lanes that need one, counted by *count. All lanes of the warp must
/// call it; the index of a lane without need is undefined.
__device__ inline std::uint32_t reserve_slot(bool needs, std::uint32_t* count) {
  const unsigned all = __ballot_sync(kAllLanes, needs);
  std::uint32_t first = 0;
  if (all != 0 && lane_index() == 0)
    first = atomicAdd(count, static_cast<std::uint32_t>(__popc(all)));
  return __shfl_sync(kAllLanes, first, 0) + static_cast<std::uint32_t>(__popc(all & lanes_below()));
}

/// A place counted by counts[counter] for each lane that exists. Adds once per counter and warp:
/// lanes that add to the same counter would wait for each other. All lanes of the warp must call
/// it.
__device__ inline std::uint32_t reserve_slot_of(unsigned counter, bool exists,
                                                std::uint32_t* counts) {
  const unsigned peers = __match_any_sync(kAllLanes, counter);
  const unsigned first = lowest_bit(peers);
  std::uint32_t begin = 0;
  if (exists && lane_index() == first)
    begin = atomicAdd(&counts[counter], static_cast<std::uint32_t>(__popc(peers)));
  return __shfl_sync(kAllLanes, begin, first) +
         static_cast<std::uint32_t>(__popc(peers & lanes_below()));
}

/// The sum over this lane and all lower lanes. All lanes of the warp must call it.
template <class T>
__device__ T inclusive_sum_of_warp(T value) {
  for (unsigned distance = 1; distance < kWarp; distance *= 2) {
    const T other = __shfl_up_sync(kAllLanes, value, distance);
    if (lane_index() >= distance) value += other;
  }
  return value;
}

/// The largest of the lanes' values. All lanes of the warp must call it.
__device__ inline std::uint32_t largest_of_warp(std::uint32_t value) {
  for (unsigned distance = kWarp / 2; distance > 0; distance /= 2)
    value = max(value, __shfl_sync(kAllLanes, value, lane_index() ^ distance));
  return value;
}

template <class T>
struct BlockSum {
  T before;  ///< over the lower threads
  T total;   ///< over the block
};

/// All `kBlock` threads of the block must call it.
template <unsigned kBlock, class T>
__device__ BlockSum<T> sum_of_block(T value) {
  constexpr unsigned kWarps = kBlock / kWarp;
  __shared__ T warp_totals[kWarps];
  const unsigned warp = threadIdx.x / kWarp;
  const T inclusive = inclusive_sum_of_warp(value);
  if (lane_index() == kWarp - 1) warp_totals[warp] = inclusive;
  __syncthreads();
  BlockSum<T> sum{inclusive - value, 0};
  for (unsigned w = 0; w < kWarps; ++w) {
    if (w < warp) sum.before += warp_totals[w];
    sum.total += warp_totals[w];
  }
  __syncthreads();  // the next call overwrites warp_totals
  return sum;
}

}  // namespace qs::cuda
