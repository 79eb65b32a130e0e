// SPDX-License-Identifier: MIT
//
// A context: a backend, its device and a thread pool. The caller's handle and the scenes share it,
// so they may be closed in any order.
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <stop_token>

#include <sys/types.h>

#include "base/not_copied.h"
#include "base/parallel.h"
#include "library/check/call.h"
#include "quadsplat/quadsplat.h"
#include "raster/api/renderer.h"

namespace qs::library {

class Context {
 public:
  /// Throws Error(device) if the backend cannot run on this machine.
  Context(Backend backend, int device, int threads);

  Backend backend() const { return backend_; }
  int device() const { return device_; }
  ThreadPool& pool() { return pool_; }
  /// The stream of functions whose arguments have none, a cudaStream_t.
  void* stream = nullptr;

  std::unique_ptr<Renderer> make_renderer() { return qs::make_renderer(backend_, pool_, device_); }

  /// False in a forked process, which has none of the pool's threads.
  bool is_of_this_process() const;

  /// Calls after this one throw Error(usage).
  void close() {
    const std::lock_guard lock(mutex_);
    closed_ = true;
  }

  /// Any thread may call it.
  void stop();

 private:
  friend class Use;

  Backend backend_;
  int device_;
  pid_t process_;
  bool closed_ = false;
  std::mutex mutex_;
  bool busy_ = false;        // a call uses the context
  std::stop_source source_;  // stops that call
  ThreadPool pool_;
};

/// The use of a context by a call, for the lifetime of the object.
class Use : NotCopied {
 public:
  /// Throws Error(usage) if the context was closed, belongs to another process or is being used.
  Use(Context& context, const Where& where);
  ~Use();

  /// Throws Error(usage) unless the context uses this GPU, which has the memory of `where`.
  void require_gpu(std::int32_t device, const Where& where) const;

  /// CUDA's number of the GPU of backend cuda.
  int device() const { return context_.device(); }
  ThreadPool& pool() const { return context_.pool(); }
  void* stream() const { return context_.stream; }
  const std::stop_token& stop() const { return stop_; }

 private:
  Context& context_;
  std::stop_token stop_;
};

}  // namespace qs::library

struct QsContext {
  std::shared_ptr<qs::library::Context> context;
};
