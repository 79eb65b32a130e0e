// SPDX-License-Identifier: MIT
//
// A set of Gaussians of a scene: one bit for each. Gaussian i is bit i % 8 of byte i / 8, and the
// bits behind the last Gaussian are 0, so equal sets have equal bytes.
#pragma once

#include <algorithm>
#include <atomic>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

#include "base/parallel.h"

namespace qs {

static_assert(std::endian::native == std::endian::little);

/// Gaussians [first, first + count).
struct GaussianRun {
  std::uint64_t first = 0, count = 0;
  bool operator==(const GaussianRun&) const = default;
};

class GaussianSet {
 public:
  GaussianSet() = default;
  /// No Gaussian of `size`.
  explicit GaussianSet(std::size_t size) : size_(size), words_((size + kBits - 1) / kBits) {}

  /// The Gaussians i of `size` for which has(i) is true, which is called in several threads.
  template <class Has>
  static GaussianSet where(std::size_t size, ThreadPool& pool, const Has& has) {
    GaussianSet set(size);
    pool.for_each(set.words_.size(), 1024, [&](std::size_t word) {
      std::uint64_t bits = 0;
      const std::size_t end = std::min(kBits, size - word * kBits);
      for (std::size_t bit = 0; bit < end; ++bit)
        bits |= std::uint64_t{has(word * kBits + bit)} << bit;
      set.words_[word] = bits;
    });
    return set;
  }

  /// The set whose bytes() these are, without the bits behind the last Gaussian.
  static GaussianSet of_bytes(std::size_t size, std::span<const std::byte> bytes) {
    GaussianSet set(size);
    if (const std::size_t count = std::min(bytes.size(), (size + 7) / 8); count > 0)
      std::memcpy(set.words_.data(), bytes.data(), count);
    set.clear_tail();
    return set;
  }

  std::size_t size() const { return size_; }
  bool operator[](std::size_t i) const { return words_[i / kBits] >> i % kBits & 1; }
  void add(std::size_t i) { words_[i / kBits] |= std::uint64_t{1} << i % kBits; }
  void toggle(std::size_t i) { words_[i / kBits] ^= std::uint64_t{1} << i % kBits; }
  /// The same for several threads at once.
  void add_atomically(std::size_t i) {
    const std::atomic_ref word(words_[i / kBits]);
    const std::uint64_t bit = std::uint64_t{1} << i % kBits;
    if ((word.load(std::memory_order_relaxed) & bit) == 0)
      word.fetch_or(bit, std::memory_order_relaxed);
  }

  std::size_t count() const {
    std::size_t sum = 0;
    for (const std::uint64_t word : words_) sum += static_cast<std::size_t>(std::popcount(word));
    return sum;
  }
  bool empty() const {
    return std::ranges::all_of(words_, [](std::uint64_t word) { return word == 0; });
  }

  // The other set has the same size.
  GaussianSet& operator|=(const GaussianSet& other) {
    return combine(other, [](std::uint64_t a, std::uint64_t b) { return a | b; });
  }
  GaussianSet& operator&=(const GaussianSet& other) {
    return combine(other, [](std::uint64_t a, std::uint64_t b) { return a & b; });
  }
  GaussianSet& operator^=(const GaussianSet& other) {
    return combine(other, [](std::uint64_t a, std::uint64_t b) { return a ^ b; });
  }
  GaussianSet& operator-=(const GaussianSet& other) {
    return combine(other, [](std::uint64_t a, std::uint64_t b) { return a & ~b; });
  }
  /// All Gaussians that it does not have.
  GaussianSet complement() const {
    GaussianSet all(size_);
    for (std::size_t word = 0; word < words_.size(); ++word) all.words_[word] = ~words_[word];
    all.clear_tail();
    return all;
  }
  bool operator==(const GaussianSet&) const = default;

  /// Calls each(i) for the Gaussians of the set, ascending.
  template <class Each>
  void for_each(const Each& each) const {
    for (std::size_t word = 0; word < words_.size(); ++word)
      for (std::uint64_t bits = words_[word]; bits != 0; bits &= bits - 1)
        each(word * kBits + static_cast<std::size_t>(std::countr_zero(bits)));
  }

  /// Its Gaussians as the longest runs, ascending.
  std::vector<GaussianRun> runs() const {
    std::vector<GaussianRun> runs;
    for_each([&](std::size_t i) {
      if (!runs.empty() && runs.back().first + runs.back().count == i) {
        ++runs.back().count;
      } else {
        runs.push_back({i, 1});
      }
    });
    return runs;
  }

  /// Its Gaussians by their numbers, ascending.
  std::vector<std::uint32_t> numbers() const {
    std::vector<std::uint32_t> numbers;
    numbers.reserve(count());
    for_each([&](std::size_t i) { numbers.push_back(static_cast<std::uint32_t>(i)); });
    return numbers;
  }

  std::span<const std::byte> bytes() const {
    return std::as_bytes(std::span(words_)).first((size_ + 7) / 8);
  }
  std::size_t memory() const { return words_.capacity() * sizeof(std::uint64_t); }

 private:
  static constexpr std::size_t kBits = 64;

  void clear_tail() {
    if (size_ % kBits != 0) words_.back() &= (std::uint64_t{1} << size_ % kBits) - 1;
  }

  template <class Combined>
  GaussianSet& combine(const GaussianSet& other, const Combined& combined) {
    for (std::size_t word = 0; word < words_.size(); ++word)
      words_[word] = combined(words_[word], other.words_[word]);
    return *this;
  }

  std::size_t size_ = 0;
  std::vector<std::uint64_t> words_;
};

}  // namespace qs
