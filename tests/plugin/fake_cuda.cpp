// SPDX-License-Identifier: MIT
//
// A libcuda.so.1 with the functions that plugins' device memory needs, for machines without a GPU.
// Its device memory is host memory, so a plugin can draw into it without CUDA.
#include <cstddef>
#include <cstdlib>
#include <cstring>

namespace {

using Address = unsigned long long;

int current_context = 0;  // 1: the primary context is current

void* pointer(Address address) { return reinterpret_cast<void*>(address); }

// Calls without a current context fail as the driver's do (CUDA_ERROR_INVALID_CONTEXT).
int checked(bool success) { return current_context == 0 ? 201 : success ? 0 : 2; }

}  // namespace

extern "C" {

int cuInit(unsigned) { return 0; }

int cuDeviceGet(int* device, int number) {
  *device = number;
  return number == 0 ? 0 : 101;  // CUDA_ERROR_INVALID_DEVICE
}

int cuDevicePrimaryCtxRetain(void** context, int) {
  *context = &current_context;
  return 0;
}

int cuDevicePrimaryCtxRelease_v2(int) { return 0; }

int cuCtxSetCurrent(void* context) {
  current_context = context == &current_context ? 1 : 0;
  return 0;
}

int cuCtxSynchronize() { return checked(true); }

int cuMemAlloc_v2(Address* address, std::size_t bytes) {
  void* const memory = std::malloc(bytes);
  *address = reinterpret_cast<Address>(memory);
  return checked(memory != nullptr);
}

int cuMemFree_v2(Address address) {
  std::free(pointer(address));
  return checked(true);
}

int cuMemsetD8_v2(Address address, unsigned char value, std::size_t count) {
  std::memset(pointer(address), value, count);
  return checked(true);
}

int cuMemcpyHtoD_v2(Address to, const void* from, std::size_t bytes) {
  std::memcpy(pointer(to), from, bytes);
  return checked(true);
}

int cuMemcpyDtoH_v2(void* to, Address from, std::size_t bytes) {
  std::memcpy(to, pointer(from), bytes);
  return checked(true);
}

}  // extern "C"
