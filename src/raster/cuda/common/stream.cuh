// SPDX-License-Identifier: MIT
//
// Owned streams and events, and blocking copies from the device to the host.
#pragma once

#include <vector>

#include "raster/cuda/common/device_buffer.cuh"

namespace qs::cuda {

/// The constructor selects the GPU, so a Stream must be constructed before anything is allocated on
/// that GPU.
class Stream {
 public:
  /// If two streams compete for a multiprocessor, the `urgent` one has priority.
  Stream(int device, bool urgent) {
    check(cudaSetDevice(device), "cudaSetDevice");
    int lowest = 0, highest = 0;
    check(cudaDeviceGetStreamPriorityRange(&lowest, &highest), "cudaStreamCreate");
    check(cudaStreamCreateWithPriority(&stream_, cudaStreamNonBlocking, urgent ? highest : lowest),
          "cudaStreamCreate");
  }
  Stream& operator=(Stream&&) = delete;  // neither copied nor moved, as the others
  ~Stream() { cudaStreamDestroy(stream_); }

  operator cudaStream_t() const { return stream_; }

 private:
  cudaStream_t stream_ = nullptr;
};

/// A point in one stream that other streams and the host can wait for.
class Event {
 public:
  explicit Event(unsigned flags = cudaEventDisableTiming) {
    check(cudaEventCreateWithFlags(&event_, flags), "cudaEventCreate");
  }
  Event& operator=(Event&&) = delete;
  ~Event() { cudaEventDestroy(event_); }

  void record(cudaStream_t stream, const char* what = "cudaEventRecord") {
    check(cudaEventRecord(event_, stream), what);
  }
  /// Work enqueued in `stream` from now on waits for the event. The host does not wait.
  void make_wait(cudaStream_t stream) const {
    check(cudaStreamWaitEvent(stream, event_, 0), "cudaStreamWaitEvent");
  }
  /// The host waits.
  void wait(const char* what = "cudaEventSynchronize") const {
    check(cudaEventSynchronize(event_), what);
  }

 protected:
  cudaEvent_t event_ = nullptr;
};

/// An event with its time on the GPU's clock.
struct TimedEvent : Event {
  TimedEvent() : Event(cudaEventDefault) {}

  /// Both events must have passed.
  float ms_since(const TimedEvent& first, const char* what = "cudaEventElapsedTime") const {
    float ms = 0;
    check(cudaEventElapsedTime(&ms, first.event_, event_), what);
    return ms;
  }
};

/// Enqueues the copy of `count` elements to the GPU.
template <class T>
void copy_to_device(const T* from, std::size_t count, T* to, cudaStream_t stream) {
  if (count == 0) return;
  check(cudaMemcpyAsync(to, from, count * sizeof(T), cudaMemcpyHostToDevice, stream),
        "copy to the GPU");
}

/// copy_to_device() of a whole array, with room for it, as DeviceBuffer::reserve() makes it.
template <class Array, class T>
void copy_to_device(const char* what, const Array& from, DeviceBuffer<T>& to, cudaStream_t stream) {
  to.reserve(what, from.size());
  copy_to_device(from.data(), from.size(), to.data(), stream);
}

/// Enqueues the copy of `count` elements to the host.
template <class T>
void enqueue_copy_to_host(const T* from, T* to, std::size_t count, cudaStream_t stream) {
  check(cudaMemcpyAsync(to, from, count * sizeof(T), cudaMemcpyDeviceToHost, stream),
        "copy to the host");
}

/// Copies `count` elements to the host and waits.
template <class T>
void copy_to_host(const T* from, T* to, std::size_t count, cudaStream_t stream) {
  if (count == 0) return;
  enqueue_copy_to_host(from, to, count, stream);
  check(cudaStreamSynchronize(stream), "frame");
}

/// Copies to an array that is resized to `count`, and waits.
template <class T>
void copy_to_host(const T* from, std::vector<T>& to, std::size_t count, cudaStream_t stream) {
  to.resize(count);
  copy_to_host(from, to.data(), count, stream);
}

template <class T>
std::vector<T> copied(const T* from, std::size_t count, cudaStream_t stream) {
  std::vector<T> host;
  copy_to_host(from, host, count, stream);
  return host;
}

}  // namespace qs::cuda
