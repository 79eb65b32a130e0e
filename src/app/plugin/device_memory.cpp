// SPDX-License-Identifier: MIT
#include "app/plugin/device_memory.h"

#include <algorithm>
#include <vector>

#include <dlfcn.h>

#include "base/fail.h"

namespace qs {
namespace {

// The part of the driver's binary interface that is used here, as in its API reference.
using Result = int;
using Device = int;
using Context = void*;
using Address = unsigned long long;

Address address_of(const void* memory) { return reinterpret_cast<Address>(memory); }

}  // namespace

struct DeviceMemory::Driver {
  /// A function of the driver, as every type of function.
  struct Function {
    void* address;
    template <class Type>
    operator Type*() const {
      return reinterpret_cast<Type*>(address);
    }
  };

  static void* open_library() {
    void* const library = dlopen("libcuda.so.1", RTLD_NOW | RTLD_LOCAL);
    if (library != nullptr) return library;
    fail(ErrorKind::device, "needs a GPU, but CUDA's driver cannot be loaded: {}", dlerror());
  }
  Function find(const char* name) const {
    void* const address = dlsym(library.get(), name);
    if (address == nullptr) fail(ErrorKind::device, "CUDA's driver lacks {}", name);
    return {address};
  }

  std::unique_ptr<void, int (*)(void*)> library{open_library(), dlclose};
  Result (*init)(unsigned) = find("cuInit");
  Result (*get_device)(Device*, int) = find("cuDeviceGet");
  Result (*retain)(Context*, Device) = find("cuDevicePrimaryCtxRetain");
  Result (*release)(Device) = find("cuDevicePrimaryCtxRelease_v2");
  Result (*set_current)(Context) = find("cuCtxSetCurrent");
  Result (*allocate)(Address*, std::size_t) = find("cuMemAlloc_v2");
  Result (*free)(Address) = find("cuMemFree_v2");
  Result (*fill)(Address, unsigned char, std::size_t) = find("cuMemsetD8_v2");
  Result (*to_device)(Address, const void*, std::size_t) = find("cuMemcpyHtoD_v2");
  Result (*to_host)(void*, Address, std::size_t) = find("cuMemcpyDtoH_v2");
  Result (*synchronise)() = find("cuCtxSynchronize");
  Device device = 0;
  bool retained = false;
  std::vector<Address> memory;

  ~Driver() {
    for (const Address address : memory) free(address);
    if (retained) release(device);
  }
};

namespace {

void check(Result result, const char* what) {
  if (result != 0) fail(ErrorKind::device, "CUDA's driver: {}: error {}", what, result);
}

}  // namespace

DeviceMemory::DeviceMemory(int device) : driver_(std::make_unique<Driver>()) {
  check(driver_->init(0), "cuInit");
  check(driver_->get_device(&driver_->device, device), "cuDeviceGet");
  Context context = nullptr;
  check(driver_->retain(&context, driver_->device), "cuDevicePrimaryCtxRetain");
  driver_->retained = true;
  check(driver_->set_current(context), "cuCtxSetCurrent");
}

DeviceMemory::~DeviceMemory() = default;

void* DeviceMemory::allocate(std::size_t bytes) {
  Address address = 0;
  check(driver_->allocate(&address, std::max<std::size_t>(bytes, 1)), "cuMemAlloc");
  driver_->memory.push_back(address);
  return reinterpret_cast<void*>(address);
}

void* DeviceMemory::copied(const void* host, std::size_t bytes) {
  void* const memory = allocate(bytes);
  if (bytes > 0) check(driver_->to_device(address_of(memory), host, bytes), "cuMemcpyHtoD");
  return memory;
}

void DeviceMemory::free(void* memory) {
  std::erase(driver_->memory, address_of(memory));
  check(driver_->free(address_of(memory)), "cuMemFree");
}

void DeviceMemory::fill(void* memory, std::uint8_t value, std::size_t bytes) {
  check(driver_->fill(address_of(memory), value, bytes), "cuMemsetD8");
  check(driver_->synchronise(), "cuCtxSynchronize");
}

void DeviceMemory::copy_to_host(const void* memory, void* host, std::size_t bytes) {
  check(driver_->synchronise(), "cuCtxSynchronize");
  check(driver_->to_host(host, address_of(memory), bytes), "cuMemcpyDtoH");
}

}  // namespace qs
