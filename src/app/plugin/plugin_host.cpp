// SPDX-License-Identifier: MIT
#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstring>
#include <memory>
#include <optional>
#include <string_view>
#include <vector>

#include <dlfcn.h>
#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/socket.h>

#include "app/plugin/protocol.h"
#include "app/plugin/scene_arrays.h"
#include "base/fail.h"
#include "base/not_copied.h"
#include "base/seconds.h"

namespace qs {
namespace {

template <std::size_t kBytes>
void copy_text(std::string_view text, PluginText<kBytes>& to) {
  to = {};
  std::transform(text.begin(), text.begin() + std::min(text.size(), kBytes - 1), to.begin(),
                 [](char c) { return static_cast<unsigned char>(c) < ' ' ? ' ' : c; });
}

// Text that a plugin wrote into a buffer or points to, up to `most` bytes.
std::string_view text_of(const char* text, std::size_t most) {
  return text == nullptr ? std::string_view() : std::string_view(text, strnlen(text, most));
}

bool is_name(std::string_view name) {
  return !name.empty() && name.size() <= 32 && std::ranges::all_of(name, [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
           std::string_view("-_.+").find(c) != std::string_view::npos;
  });
}

const QsPlugin& load(const std::string& library) {
  void* const handle = dlopen(library.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (handle == nullptr) fail("cannot be loaded: {}", dlerror());
  const auto find = reinterpret_cast<const QsPlugin* (*)()>(dlsym(handle, "qs_plugin"));
  if (find == nullptr) fail("is no plugin: it does not export qs_plugin()");
  const QsPlugin* const plugin = find();
  if (plugin == nullptr) fail("is no plugin: qs_plugin() returned null");
  if (plugin->version != QS_PLUGIN_VERSION)
    fail("has version {} of the interface, but this program has version {}", plugin->version,
         QS_PLUGIN_VERSION);
  if (plugin->memory > QS_MEMORY_CUDA) fail("has the unknown kind of memory {}", plugin->memory);
  if (plugin->image_layout > QS_IMAGE_CHW)
    fail("has the unknown image layout {}", plugin->image_layout);
  if (!is_name(text_of(plugin->name, 64)))
    fail("has a name that is not 1 to 32 letters, digits and - _ . +");
  if (plugin->open == nullptr || plugin->render == nullptr || plugin->close == nullptr)
    fail("lacks one of its functions open, render and close");
  return *plugin;
}

// Memory of a GPU for plugins that draw on it. It uses CUDA's driver, loaded when it is first
// needed, so that a program built without CUDA can measure plugins that use it.
class DeviceMemory : NotCopied {
 public:
  /// Makes the primary context of a GPU current in this thread. Throws Error(device) without a
  /// driver or such a GPU.
  explicit DeviceMemory(int device) {
    check(init_(0), "cuInit");
    check(get_device_(&device_, device), "cuDeviceGet");
    Context context = nullptr;
    check(retain_(&context, device_), "cuDevicePrimaryCtxRetain");
    check(set_current_(context), "cuCtxSetCurrent");
  }
  /// Frees all memory.
  ~DeviceMemory() {
    for (const Address address : memory_) free_(address);
    release_(device_);
  }

  /// Addresses in device memory, as CUDA's runtime accepts them. They throw Error(device).
  void* allocate(std::size_t bytes) {
    Address address = 0;
    check(allocate_(&address, std::max<std::size_t>(bytes, 1)), "cuMemAlloc");
    memory_.push_back(address);
    return reinterpret_cast<void*>(address);
  }
  void* copied(const void* host, std::size_t bytes) {
    void* const memory = allocate(bytes);
    if (bytes > 0) check(to_device_(address_of(memory), host, bytes), "cuMemcpyHtoD");
    return memory;
  }
  void free(void* memory) {
    std::erase(memory_, address_of(memory));
    check(free_(address_of(memory)), "cuMemFree");
  }
  void fill(void* memory, std::uint8_t value, std::size_t bytes) {
    check(fill_(address_of(memory), value, bytes), "cuMemsetD8");
    check(synchronise_(), "cuCtxSynchronize");
  }
  void copy_to_host(const void* memory, void* host, std::size_t bytes) {
    check(synchronise_(), "cuCtxSynchronize");
    check(to_host_(host, address_of(memory), bytes), "cuMemcpyDtoH");
  }

 private:
  // The part of the driver's binary interface that is used here, as in its API reference.
  using Result = int;
  using Device = int;
  using Context = void*;
  using Address = unsigned long long;

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
    void* const address = dlsym(library_.get(), name);
    if (address == nullptr) fail(ErrorKind::device, "CUDA's driver lacks {}", name);
    return {address};
  }
  static Address address_of(const void* memory) { return reinterpret_cast<Address>(memory); }
  static void check(Result result, const char* what) {
    if (result != 0) fail(ErrorKind::device, "CUDA's driver: {}: error {}", what, result);
  }

  std::unique_ptr<void, int (*)(void*)> library_{open_library(), dlclose};
  Result (*init_)(unsigned) = find("cuInit");
  Result (*get_device_)(Device*, int) = find("cuDeviceGet");
  Result (*retain_)(Context*, Device) = find("cuDevicePrimaryCtxRetain");
  Result (*release_)(Device) = find("cuDevicePrimaryCtxRelease_v2");
  Result (*set_current_)(Context) = find("cuCtxSetCurrent");
  Result (*allocate_)(Address*, std::size_t) = find("cuMemAlloc_v2");
  Result (*free_)(Address) = find("cuMemFree_v2");
  Result (*fill_)(Address, unsigned char, std::size_t) = find("cuMemsetD8_v2");
  Result (*to_device_)(Address, const void*, std::size_t) = find("cuMemcpyHtoD_v2");
  Result (*to_host_)(void*, Address, std::size_t) = find("cuMemcpyDtoH_v2");
  Result (*synchronise_)() = find("cuCtxSynchronize");
  Device device_ = 0;
  std::vector<Address> memory_;
};

// The library that was loaded, with the scene that it opened.
class Host {
 public:
  explicit Host(std::string library) : library_(std::move(library)) {}

  void answer(const PluginRequest& request, PluginReply& reply) {
    if (request.call == PluginCall::open) return open(request, reply);
    if (request.call == PluginCall::render) return render(request, reply);
    if (request.call == PluginCall::close) plugin_->close(renderer_);
  }

 private:
  void open(const PluginRequest& request, PluginReply& reply) {
    plugin_ = &load(library_);
    reply.memory = plugin_->memory;
    reply.image_layout = plugin_->image_layout;
    copy_text(text_of(plugin_->name, 32), reply.name);
    copy_text(text_of(plugin_->description, 255), reply.description);
    scene_ = request.scene;
    scene_memory_ = Mapping(kPluginScene, scene_bytes(scene_));
    point_into(scene_memory_, scene_);
    if (plugin_->memory == QS_MEMORY_CUDA) {
      device_.emplace(scene_.device);
      copy_to_device();
    }
    char message[QS_MESSAGE_BYTES] = {};
    const std::int32_t code = plugin_->open(&scene_, &renderer_, message);
    if (code != 0) refuse("open", code, message);
  }

  void copy_to_device() {
    for (const SceneArray& array : scene_arrays(scene_))
      scene_.*array.member = static_cast<const float*>(
          device_->copied(scene_.*array.member, scene_.count * array.width * sizeof(float)));
    scene_memory_ = {};
  }

  void render(const PluginRequest& request, PluginReply& reply) {
    const std::size_t bytes = 3 * sizeof(float) * static_cast<std::size_t>(request.view.width) *
                              static_cast<std::size_t>(request.view.height);
    if (bytes != image_memory_.size()) resize_image(bytes);
    // Values that the plugin does not write are NaN.
    if (request.wants_image != 0) {
      if (device_) device_->fill(device_image_, 0xff, bytes);
      std::memset(image_memory_.data(), 0xff, bytes);
    }
    QsFrame frame = {};
    frame.image = device_ ? static_cast<float*>(device_image_) : image_memory_.floats();
    frame.mark_stages = request.mark_stages;
    char message[QS_MESSAGE_BYTES] = {};
    const auto start = std::chrono::steady_clock::now();
    const std::int32_t code = plugin_->render(renderer_, &request.view, &frame, message);
    reply.call_ms = milliseconds_since(start);
    if (code != 0) refuse("render", code, message);
    reply.frame = frame;
    if (request.wants_image != 0 && device_)
      device_->copy_to_host(device_image_, image_memory_.data(), bytes);
  }

  void resize_image(std::size_t bytes) {
    image_memory_ = {};
    image_memory_ = Mapping(kPluginImage, bytes);
    if (!device_) return;
    if (device_image_ != nullptr) device_->free(device_image_);
    device_image_ = device_->allocate(bytes);
  }

  [[noreturn]] static void refuse(const char* function, std::int32_t code, const char* message) {
    const std::string_view text = text_of(message, QS_MESSAGE_BYTES);
    fail(ErrorKind::device, "{}() returned {}: {}", function, code,
         text.empty() ? "no reason" : text);
  }

  std::string library_;
  const QsPlugin* plugin_ = nullptr;
  void* renderer_ = nullptr;
  QsScene scene_ = {};
  Mapping scene_memory_, image_memory_;
  std::optional<DeviceMemory> device_;
  void* device_image_ = nullptr;
};

}  // namespace

int run_plugin_host(const std::string& library) {
  // A plugin that hangs is killed when the thread of quadsplat that started this process ends.
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  // Processes that the plugin starts do not keep these open.
  for (const int descriptor : {kPluginSocket, kPluginScene, kPluginImage})
    if (fcntl(descriptor, F_SETFD, FD_CLOEXEC) != 0)
      fail(ErrorKind::usage, "{}: only quadsplat starts this command", kPluginHostCommand);
  Host host(library);
  PluginRequest request;
  while (recv(kPluginSocket, &request, sizeof request, 0) == sizeof request) {
    PluginReply reply;
    try {
      host.answer(request, reply);
    } catch (const std::exception& error) {
      reply.failed = 1;
      copy_text(error.what(), reply.message);
    }
    if (send(kPluginSocket, &reply, sizeof reply, MSG_NOSIGNAL) != sizeof reply) break;
  }
  return 0;
}

}  // namespace qs
