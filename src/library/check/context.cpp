// SPDX-License-Identifier: MIT
#include "library/check/context.h"

#include <unistd.h>

#include "io/bytes/mapped_file.h"

namespace qs::library {
namespace {

// From the start, because functions without a context read files too.
[[maybe_unused]] const bool kCopiesFiles = [] {
  MappedFile::copy_files(true);
  return true;
}();

Backend chosen_backend(std::uint32_t backend, const Where& where) {
  if (backend == QS_BACKEND_AUTO) return available_backends().front();
  if (backend == QS_BACKEND_CPU) return Backend::cpu;
  if (backend == QS_BACKEND_CUDA) return Backend::cuda;
  refuse(where, "{} is none of QS_BACKEND_AUTO, _CPU and _CUDA", backend);
}
}  // namespace

Context::Context(Backend backend, int device, int threads)
    : backend_(backend), device_(device), process_(getpid()), pool_(threads) {
  if (backend_ == Backend::cpu) return;
  if (device_ == kFirstGpu) device_ = first_gpu();
  make_renderer();  // throws without a usable GPU
}

bool Context::is_of_this_process() const { return process_ == getpid(); }

void Context::stop() {
  if (!is_of_this_process()) return;
  const std::lock_guard lock(mutex_);
  if (busy_) source_.request_stop();
}

Use::Use(Context& context, const Where& where) : context_(context) {
  // First, because another thread may have held the mutex when the process was forked.
  if (!context.is_of_this_process())
    refuse(where,
           "belongs to the process from which this process was forked: open a context here, or "
           "start processes without fork");
  const std::lock_guard lock(context.mutex_);
  if (context.closed_) refuse(where, "its context was closed");
  if (context.busy_) refuse(where, "another thread uses this context: open one for each thread");
  if (context.source_.stop_requested()) context.source_ = std::stop_source();
  stop_ = context.source_.get_token();
  context.busy_ = true;
}

void Use::require_gpu(std::int32_t device, const Where& where) const {
  if (context_.backend() != Backend::cuda)
    refuse(where,
           "is in the memory of GPU {}, but the context has the backend cpu: open one with "
           "QS_BACKEND_CUDA",
           device);
  if (device != this->device())
    refuse(where, "is in the memory of GPU {}, but the context uses GPU {}", device,
           this->device());
}

Use::~Use() {
  const std::lock_guard lock(context_.mutex_);
  context_.busy_ = false;
}

}  // namespace qs::library

using namespace qs::library;

int32_t qs_context_open(uint32_t backend, int32_t device, int32_t threads, QsContext** context,
                        char* message) {
  return library::call(__func__, message, "context", context, [&](const char* function) {
    *context = nullptr;
    if (device < QS_FIRST_GPU) refuse({function, "device"}, "is {}", device);
    constexpr int kMostThreads = 1024;
    if (threads < 0 || threads > kMostThreads)
      refuse({function, "threads"}, "{} is not between 0 and {}", threads, kMostThreads);
    *context = new QsContext{
        std::make_shared<Context>(chosen_backend(backend, {function, "backend"}), device, threads)};
  });
}

void qs_context_close(QsContext* context) {
  // The threads of a forked process's pool do not exist, so waiting for them would never end.
  if (context == nullptr || !context->context->is_of_this_process()) return;
  context->context->close();
  delete context;
}

uint32_t qs_context_backend(const QsContext* context) {
  if (context == nullptr) return 0;
  return context->context->backend() == Backend::cpu ? QS_BACKEND_CPU : QS_BACKEND_CUDA;
}

int32_t qs_context_stream(QsContext* context, void* stream, char* message) {
  return library::call(__func__, message, "context", context, [&](const char* function) {
    const Use use(*context->context, {function, "context"});
    context->context->stream = stream;
  });
}

void qs_stop(QsContext* context) {
  if (context != nullptr) context->context->stop();
}
