// SPDX-License-Identifier: MIT
#include <cstring>
#include <functional>

#include "io/bytes/zip.h"
#include "io/tensor/torch_tensor.h"

namespace qs {
namespace {

std::string bytes_of_floats(const std::vector<float>& values) {
  std::string bytes(values.size() * sizeof(float), '\0');
  if (!values.empty()) std::memcpy(bytes.data(), values.data(), bytes.size());
  return bytes;
}

// Describes a storage outside of the pickle. Old streams have one more field, the view.
void add_storage(PickleWriter& pickle, const std::string& key, std::size_t count, bool old) {
  pickle.begin().text("storage").name("torch", "FloatStorage").text(key).text("cpu");
  pickle.integer(static_cast<std::int64_t>(count));
  if (old) pickle.none();
  pickle.tuple().persistent();
}

// A stream of PyTorch before 1.6 that holds one storage: its magic number, version, the machine's
// integers, the object and the keys of storages are pickles; the number of values and they follow.
std::string storage_stream(const std::vector<float>& values) {
  std::string stream("\x80\x02\x8a\x0a\x6c\xfc\x9c\x46\xf9\x20\x6a\xa8\x50\x19.", 15);
  stream += PickleWriter().integer(1001).take();
  PickleWriter machine;
  machine.dictionary().begin().text("protocol_version").integer(1001).text("little_endian");
  machine.boolean(true).text("type_sizes").dictionary().begin();
  for (const char* type : {"short", "int", "long"})
    machine.text(type).integer(type[0] == 's' ? 2 : 4);
  stream += machine.set_items().set_items().take();
  PickleWriter object;
  add_storage(object, "0", values.size(), true);
  stream += object.take() + PickleWriter().list().begin().text("0").append().take();
  const std::uint64_t count = values.size();
  std::string number(sizeof count, '\0');
  std::memcpy(number.data(), &count, sizeof count);
  return stream + number + bytes_of_floats(values);
}

// `storage` appends the values' storage of a tensor.
void add_tensors(PickleWriter& pickle, std::span<const NamedTensor> tensors,
                 const std::function<void(std::size_t number)>& storage) {
  pickle.name("collections", "OrderedDict").begin().tuple().call().begin();
  for (std::size_t i = 0; i < tensors.size(); ++i) {
    const std::vector<std::uint64_t>& shape = tensors[i].tensor.shape;
    pickle.text(tensors[i].name).name("torch._utils", "_rebuild_tensor_v2").begin();
    storage(i);
    pickle.integer(0).begin();
    for (const std::uint64_t side : shape) pickle.integer(static_cast<std::int64_t>(side));
    pickle.tuple().begin();
    for (std::size_t axis = 0; axis < shape.size(); ++axis) {
      std::uint64_t stride = 1;
      for (std::size_t inner = axis + 1; inner < shape.size(); ++inner) stride *= shape[inner];
      pickle.integer(static_cast<std::int64_t>(stride));
    }
    pickle.tuple().boolean(false).name("collections", "OrderedDict").begin().tuple().call();
    pickle.tuple().call();
  }
  pickle.set_items();
}

}  // namespace

void add_embedded_tensors(PickleWriter& pickle, std::span<const NamedTensor> tensors) {
  add_tensors(pickle, tensors, [&](std::size_t i) {
    pickle.name("torch.storage", "_load_from_bytes").begin();
    pickle.bytes(storage_stream(tensors[i].tensor.values)).tuple().call();
  });
}

void write_torch_file(const std::filesystem::path& path, std::span<const NamedTensor> tensors) {
  const std::string folder = path.stem().string();
  PickleWriter pickle;
  add_tensors(pickle, tensors, [&](std::size_t i) {
    add_storage(pickle, std::to_string(i), tensors[i].tensor.values.size(), false);
  });
  std::vector<ZipEntry> entries = {{folder + "/data.pkl", pickle.take()}};
  for (std::size_t i = 0; i < tensors.size(); ++i) {
    entries.push_back(
        {folder + "/data/" + std::to_string(i), bytes_of_floats(tensors[i].tensor.values)});
  }
  entries.push_back({folder + "/version", "3\n"});
  write_zip(path, entries, false);
}

}  // namespace qs
