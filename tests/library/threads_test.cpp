// SPDX-License-Identifier: MIT
// Contexts of many threads and processes, and their memory.
#include <atomic>
#include <chrono>
#include <memory>
#include <string>
#include <thread>

#include <malloc.h>
#include <sys/wait.h>
#include <unistd.h>

#include "library/opened_scene.h"
#include "support/scenes.h"

#if defined(__SANITIZE_THREAD__)
#define QS_THREADS_AFTER_FORK 0  // ThreadSanitizer ends such a process
#else
#define QS_THREADS_AFTER_FORK 1
#endif

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define QS_OWN_ALLOCATOR 1
#else
#define QS_OWN_ALLOCATOR 0
#endif

namespace qs {
namespace {

/// Bytes that the process has allocated and not freed.
std::size_t allocated_bytes() {
  const struct mallinfo2 info = mallinfo2();
  return info.uordblks + info.hblkhd;
}

QsCamera front(int width = 64, int height = 48) {
  return test::c_camera(test::front_camera(width, height));
}

TEST(LibraryContexts, ten_thousand_leave_no_memory) {
  const auto open_and_close = [](int count, int threads) {
    for (int i = 0; i < count; ++i) quadsplat::Context context(QS_BACKEND_CPU, 0, threads);
  };
  open_and_close(100, 2);
  const std::size_t before = allocated_bytes();
  open_and_close(9000, 1);
  open_and_close(1000, 2);
  if (!QS_OWN_ALLOCATOR) {
    EXPECT_LT(allocated_bytes(), before + 64 * 1024);
  }
}

TEST(LibraryContexts, and_scenes_leave_no_memory) {
  const GaussianCloud cloud = test::random_cloud(1000, 1, 1);
  const auto draw = [&](int count) {
    for (int i = 0; i < count; ++i) {
      quadsplat::Context context = test::cpu(1);
      quadsplat::Scene scene = context.wrap(test::gaussians_of(cloud));
      test::rendered(scene, front());
      scene.lists(front());
    }
  };
  draw(5);
  const std::size_t before = allocated_bytes();
  draw(100);
  if (!QS_OWN_ALLOCATOR) {
    EXPECT_LT(allocated_bytes(), before + 64 * 1024);
  }
}

TEST(LibraryContexts, frames_after_the_first_keep_the_memory) {
  quadsplat::Context context = test::cpu();
  quadsplat::Scene scene = context.wrap(test::gaussians_of(test::random_cloud(3000, 1, 1)));
  const QsCamera camera = front();
  test::Results results;
  const QsPicture picture = test::picture_of(results, camera);
  for (int i = 0; i < 3; ++i) scene.render(camera, picture);
  const std::size_t before = allocated_bytes();
  for (int i = 0; i < 200; ++i) scene.render(camera, picture);
  if (!QS_OWN_ALLOCATOR) {
    EXPECT_LE(allocated_bytes(), before + 1024);
  }
}

TEST(LibraryContexts, of_four_threads_draw_at_the_same_time) {
  const GaussianCloud cloud = test::random_cloud(3000, 2, 1);
  quadsplat::Context one = test::cpu(1);
  quadsplat::Scene scene = one.wrap(test::gaussians_of(cloud));
  const std::vector<float> expected = test::colors(scene, front());
  std::atomic<int> equal = 0;
  std::vector<std::thread> threads;
  for (int i = 0; i < 4; ++i) {
    threads.emplace_back([&, i] {
      quadsplat::Context context = test::cpu(1 + i % 3);
      quadsplat::Scene own = context.wrap(test::gaussians_of(cloud));
      for (int frame = 0; frame < 10; ++frame)
        equal += test::colors(own, front()) == expected ? 1 : 0;
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(equal, 40);
}

TEST(LibraryContexts, pass_from_thread_to_thread) {
  quadsplat::Context context = test::cpu();
  std::unique_ptr<quadsplat::Scene> scene;
  std::vector<float> first;
  for (int i = 0; i < 8; ++i) {
    std::thread([&] {
      if (!scene)
        scene = std::make_unique<quadsplat::Scene>(
            context.wrap(test::gaussians_of(test::random_cloud(3000, 1, 1))));
      const std::vector<float> values = test::colors(*scene, front());
      if (first.empty()) first = values;
      EXPECT_EQ(values, first);
    }).join();
  }
  std::thread([&] { scene.reset(); }).join();
}

/// A view in mode reference that takes many seconds, on a thread of its own.
class LongCall {
 public:
  explicit LongCall(quadsplat::Context& context)
      : scene_(context.wrap(test::gaussians_of(test::random_cloud(20000, 3, 1)))),
        call_([this] { draw(); }) {}

  /// Stops it until it ends, because it may not have begun. Returns its sentence.
  std::string stop(quadsplat::Context& context) {
    while (!ended_) {
      context.stop();
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    call_.join();
    return sentence_;
  }
  quadsplat::Scene& scene() { return scene_; }

 private:
  void draw() {
    QsSettings settings = QS_SETTINGS;
    settings.cull = "reference";
    std::int32_t code = QS_USAGE;
    while (code == QS_USAGE) {  // a call of the test uses the context
      try {
        code = QS_OK;
        test::colors(scene_, front(4000, 3000), settings);
      } catch (const quadsplat::Error& error) {
        code = error.code();
        sentence_ = error.what();
      }
    }
    EXPECT_EQ(code, QS_CANCELLED);
    ended_ = true;
  }

  quadsplat::Scene scene_;
  std::atomic<bool> ended_ = false;
  std::string sentence_;
  std::thread call_;
};

TEST(LibraryContexts, are_stopped_by_another_thread_and_work_afterwards) {
  quadsplat::Context context = test::cpu();
  context.stop();  // no call runs
  LongCall call(context);
  EXPECT_EQ(call.stop(context), "cancelled");
  EXPECT_EQ(test::rendered(call.scene(), front()).counts.gaussians, 20000u);
}

TEST(LibraryContexts, refuse_a_second_thread) {
  quadsplat::Context context = test::cpu();
  LongCall call(context);
  std::string sentence;
  while (sentence.empty()) {
    // The first calls may come before the long call.
    sentence =
        test::sentence_of([&] { context.wrap(test::gaussians_of(test::random_cloud(1, 0, 1))); });
  }
  EXPECT_EQ(sentence,
            "qs_scene_wrap: context: another thread uses this context: open one for each thread");
  EXPECT_EQ(call.stop(context), "cancelled");
}

TEST(LibraryContexts, and_their_scenes_close_in_any_order) {
  auto context = std::make_unique<quadsplat::Context>(QS_BACKEND_CPU, 0, 2);
  quadsplat::Scene scene = context->wrap(test::gaussians_of(test::random_cloud(100, 0, 1)));
  quadsplat::Scene drawn = context->wrap(test::gaussians_of(test::random_cloud(100, 0, 1)));
  test::rendered(drawn, front());
  context.reset();
  EXPECT_EQ(test::sentence_of([&] { test::rendered(scene, front()); }),
            "qs_render: scene: its context was closed");
  EXPECT_EQ(test::sentence_of([&] { drawn.lists(front()); }),
            "qs_lists: scene: its context was closed");
  EXPECT_EQ(scene.facts().gaussians, 100u);
}

// ThreadSanitizer sees a race if closing does not take the context's mutex.
TEST(LibraryContexts, close_while_another_thread_uses_a_scene) {
  for (int i = 0; i < 20; ++i) {
    auto context = std::make_unique<quadsplat::Context>(test::cpu(1));
    quadsplat::Scene scene = context->wrap(test::gaussians_of(test::random_cloud(10, 0, 1)));
    std::string sentence;
    std::thread other([&] {
      while (sentence.empty())
        sentence = test::sentence_of([&] { test::rendered(scene, front(16, 16)); });
    });
    context.reset();
    other.join();
    EXPECT_EQ(sentence, "qs_render: scene: its context was closed");
  }
}

TEST(LibraryContexts, are_refused_in_a_forked_process) {
  if (!QS_THREADS_AFTER_FORK) GTEST_SKIP() << "ThreadSanitizer starts no threads after fork()";
  quadsplat::Context context = test::cpu();
  quadsplat::Scene scene = context.wrap(test::gaussians_of(test::random_cloud(100, 0, 1)));
  test::rendered(scene, front());
  const pid_t child = fork();
  if (child == 0) {
    const std::string expected =
        "qs_render: scene: belongs to the process from which this process was forked: open a "
        "context here, or start processes without fork";
    bool good = test::sentence_of([&] { test::rendered(scene, front()); }) == expected;
    // A context of its own works, and closing the old one does not wait for its threads.
    {
      quadsplat::Context own = test::cpu();
      quadsplat::Scene drawn = own.wrap(test::gaussians_of(test::random_cloud(100, 0, 1)));
      good = good && test::rendered(drawn, front()).counts.gaussians == 100;
    }
    context.stop();
    qs_scene_close(scene.get());
    qs_context_close(context.get());
    _exit(good ? 0 : 1);
  }
  int status = -1;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  EXPECT_EQ(status, 0);
  EXPECT_EQ(test::rendered(scene, front()).counts.gaussians, 100u);
}

}  // namespace
}  // namespace qs
