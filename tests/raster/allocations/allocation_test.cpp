// SPDX-License-Identifier: MIT
// Frames of the CPU backend allocate nothing once buffers have grown. A separate program, because
// it replaces operator new to count allocations.
#include <atomic>
#include <cstdlib>
#include <new>

#include <gtest/gtest.h>

#include "raster/api/renderer.h"
#include "support/pool.h"
#include "support/scenes.h"

namespace {

std::atomic<std::size_t> allocations = 0;  // of all threads

// Null if there is not enough memory.
void* try_to_allocate(std::size_t size, std::size_t alignment) {
  ++allocations;
  const std::size_t whole = (size + alignment - 1) / alignment * alignment;
  return std::aligned_alloc(alignment, whole);
}

void* allocate(std::size_t size, std::size_t alignment) {
  void* memory = try_to_allocate(size, alignment);
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}

}  // namespace

// The other forms call these functions, except where AddressSanitizer replaces them: it has forms
// of its own that throw nothing, which std::stable_sort() calls. They are never inlined, because
// GCC warns if only one function of a pair is inlined.
[[gnu::noinline]] void* operator new(std::size_t size) {
  return allocate(size, alignof(std::max_align_t));
}
[[gnu::noinline]] void* operator new(std::size_t size, std::align_val_t alignment) {
  return allocate(size, static_cast<std::size_t>(alignment));
}
[[gnu::noinline]] void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
  return try_to_allocate(size, alignof(std::max_align_t));
}
[[gnu::noinline]] void operator delete(void* memory, const std::nothrow_t&) noexcept {
  std::free(memory);
}
[[gnu::noinline]] void operator delete(void* memory) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::align_val_t) noexcept {
  std::free(memory);
}
[[gnu::noinline]] void operator delete(void* memory, std::size_t, std::align_val_t) noexcept {
  std::free(memory);
}

namespace qs {
namespace {

/// Number of allocations in a frame after another frame of the same view.
std::size_t allocations_of_a_frame(Renderer& renderer, const Camera& camera,
                                   const RenderSettings& settings, const Outputs& outputs) {
  renderer.render(camera, settings, outputs);
  const std::size_t before = allocations;
  renderer.render(camera, settings, outputs);
  return allocations - before;
}

TEST(Allocations, are_counted) {
  const std::size_t before = allocations;
  const std::vector<int> some(10);
  EXPECT_EQ(allocations, before + 1);
}

TEST(Allocations, of_a_frame_are_none_once_buffers_have_grown) {
  const Camera camera = test::front_camera(320, 200);
  Outputs maps;
  maps.pairs = maps.evaluated = true;
  for (const int threads : {1, 2, 5}) {
    const auto renderer = make_renderer(Backend::cpu, test::pool(threads));
    renderer->upload(test::random_cloud(20000, 3, 1), {});
    for (const Outputs& outputs : {Outputs{}, maps}) {
      RenderSettings settings;
      for (settings.mode = 1; settings.mode <= culler_count(); ++settings.mode) {
        EXPECT_EQ(allocations_of_a_frame(*renderer, camera, settings, outputs), 0u)
            << threads << " threads, mode " << settings.mode;
      }
    }
  }
}

}  // namespace
}  // namespace qs
