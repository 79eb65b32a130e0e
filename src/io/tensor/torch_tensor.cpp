// SPDX-License-Identifier: MIT
#include "io/tensor/torch_tensor.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <functional>
#include <map>
#include <utility>

#include "base/fail.h"
#include "io/bytes/byte_cursor.h"
#include "io/bytes/byte_text.h"
#include "io/bytes/zip.h"
#include "raster/kernel/half.h"

namespace qs {

namespace {

constexpr std::uint64_t kMaxPickleBytes = 16u << 20;
constexpr std::size_t kMaxDimensions = 8;
constexpr std::string_view kPickleFile = "data.pkl";

// A pickle's description of a storage outside of it.
struct StorageId {
  bool halves = false;
  std::string key;
  std::uint64_t count = 0;  ///< values
};

StorageId read_storage_id(const Pickle& pickle, PickleRef object) {
  const PickleObject& storage = pickle[object];
  if (storage.kind != PickleKind::persistent)
    fail("{}: its pickle: a tensor has no storage", pickle.source());
  const auto id = pickle.tuple(storage.items.front(), "a storage's description");
  if (id.size() < 5 || pickle.text(id[0], "the kind of an outside object") != "storage")
    fail("{}: its pickle: an outside object is no storage", pickle.source());
  const PickleObject& type = pickle[id[1]];
  if (type.kind != PickleKind::name || !type.text.ends_with("Storage"))
    fail("{}: its pickle: the type of a storage is unknown", pickle.source());
  const std::int64_t count = pickle.integer(id[4], "the size of a storage");
  if (count < 0) fail("{}: its pickle: a storage has {} values", pickle.source(), count);
  return {type.text == "torch.HalfStorage", std::string(pickle.text(id[2], "a storage's key")),
          static_cast<std::uint64_t>(count)};
}

std::uint64_t item_bytes(bool halves) { return halves ? 2 : 4; }

// The storages behind the pickles of a stream: per key a 64-bit count and the values. A storage
// that was saved alone is the stream's object itself.
using StreamStorages = std::map<std::string, TorchStorage>;

// By key: of halves?
std::map<std::string, bool> types_of(const Pickle& pickle) {
  std::map<std::string, bool> types;
  for (PickleRef object = 1; object < pickle.object_count(); ++object) {
    if (pickle[object].kind != PickleKind::persistent) continue;
    const StorageId id = read_storage_id(pickle, object);
    types[id.key] = id.halves;
  }
  return types;
}

// `cursor` stands behind the object's pickle.
StreamStorages read_storages(const Pickle& object, ByteCursor& cursor, ByteSpan content,
                             const std::string& source) {
  StreamStorages storages;
  const Pickle keys(content.subspan(cursor.offset()), source);
  cursor.take(keys.size(), "the keys");
  const PickleObject& list = keys[keys.root()];
  if (list.kind != PickleKind::list) fail("{}: lists no storages", source);
  const std::map<std::string, bool> types = types_of(object);
  for (const PickleRef item : list.items) {
    const std::string key(keys.text(item, "a storage's key"));
    const auto type = types.find(key);
    if (type == types.end()) fail("{}: lists a storage that no tensor has", source);
    const auto count = cursor.read<std::uint64_t>("the size of a storage");
    if (!fits(count, item_bytes(type->second), cursor.left()))
      fail("{}: cut off: a storage has {} values, {} bytes are left", source, count, cursor.left());
    storages[key] = {cursor.take(count * item_bytes(type->second), "a storage"), type->second};
  }
  return storages;
}

TorchStorage find_storage(const StreamStorages& storages, const std::string& key,
                          const std::string& source) {
  const auto found = storages.find(key);
  if (found == storages.end()) fail("{}: a storage is missing", source);
  return found->second;
}

// The start of a stream: its magic number, version and the sizes of the machine's integers. Returns
// the pickle of the object, behind which the cursor stands.
Pickle stream_object(ByteSpan content, ByteCursor& cursor, const std::string& source) {
  constexpr std::array kStreamMagic = {0x6c, 0xfc, 0x9c, 0x46, 0xf9, 0x20, 0x6a, 0xa8, 0x50, 0x19};
  const auto next = [&] {
    Pickle pickle(content.subspan(cursor.offset()), source);
    cursor.take(pickle.size(), "a pickle");
    return pickle;
  };
  const Pickle magic = next();
  const auto number = magic[magic.root()].bytes;
  const bool known =
      magic[magic.root()].kind == PickleKind::long_integer &&
      std::equal(number.begin(), number.end(), kStreamMagic.begin(), kStreamMagic.end(),
                 [](std::byte a, int b) { return std::to_integer<int>(a) == b; });
  if (!known) fail("{}: not a file of PyTorch", source);
  const Pickle version = next();
  if (version.integer(version.root(), "the version") != 1001)
    fail("{}: an unknown version of PyTorch's files", source);
  next();
  return next();
}

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
  put_values(stream, std::uint64_t{values.size()});
  return stream + bytes_of_floats(values);
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

Tensor read_torch_tensor(const Pickle& pickle, PickleRef object, const TorchStorages& storages,
                         const std::string& what) {
  const std::string& source = pickle.source();
  if (pickle[object].text == "torch._utils._rebuild_parameter")
    object = pickle.call(object, "torch._utils._rebuild_parameter", 1, what.c_str())[0];
  const auto arguments = pickle.call(object, "torch._utils._rebuild_tensor_v2", 4, what.c_str());
  const std::int64_t offset = pickle.integer(arguments[1], "a tensor's offset");
  const auto sizes = pickle.tuple(arguments[2], "a tensor's shape");
  const auto strides = pickle.tuple(arguments[3], sizes.size(), "a tensor's strides");
  if (sizes.size() > kMaxDimensions) fail("{}: {} has {} dimensions", source, what, sizes.size());
  const TorchStorage storage = storages(pickle, arguments[0]);
  const std::uint64_t item = item_bytes(storage.halves), stored = storage.bytes.size() / item;

  Tensor tensor;
  std::uint64_t count = 1, expected_stride = 1;
  for (const PickleRef size : sizes) {
    const std::int64_t side = pickle.integer(size, "a tensor's size");
    if (side < 0) fail("{}: {} has a side of {}", source, what, side);
    if (!fits(count, static_cast<std::uint64_t>(side), stored))
      fail("{}: {} has more values than its storage of {}", source, what, stored);
    count *= static_cast<std::uint64_t>(side);
    tensor.shape.push_back(static_cast<std::uint64_t>(side));
  }
  for (std::size_t i = sizes.size(); i-- > 0;) {
    const std::int64_t stride = pickle.integer(strides[i], "a tensor's stride");
    if (tensor.shape[i] > 1 && stride != static_cast<std::int64_t>(expected_stride))
      fail("{}: {} is not stored in one piece", source, what);
    expected_stride *= tensor.shape[i];
  }
  if (offset < 0 || static_cast<std::uint64_t>(offset) > stored ||
      count > stored - static_cast<std::uint64_t>(offset))
    fail("{}: {} has {} values from {} on, but its storage has {}", source, what, count, offset,
         stored);
  tensor.values.resize(count);
  const std::byte* const from = storage.bytes.data() + static_cast<std::uint64_t>(offset) * item;
  if (storage.halves) {
    for (std::uint64_t i = 0; i < count; ++i)
      tensor.values[i] = float_of_any_half(load<std::uint16_t>(from + 2 * i));
  } else if (count > 0) {
    std::memcpy(tensor.values.data(), from, count * sizeof(float));
  }
  return tensor;
}

TorchStorage embedded_torch_storage(const Pickle& pickle, PickleRef object) {
  const std::string& source = pickle.source();
  const auto arguments =
      pickle.call(object, "torch.storage._load_from_bytes", 1, "the storage of a tensor");
  if (pickle[arguments[0]].kind != PickleKind::bytes)
    fail("{}: its pickle: the values of a storage are not bytes", source);
  const auto content = pickle[arguments[0]].bytes;
  ByteCursor cursor(content, source);
  const Pickle stream = stream_object(content, cursor, source);
  const StorageId id = read_storage_id(stream, stream.root());
  return find_storage(read_storages(stream, cursor, content, source), id.key, source);
}

TorchFile::TorchFile(ByteSpan content, const std::filesystem::path& path) : path_(path) {
  if (is_zip(content))
    open_archive(content);
  else
    open_stream(content);
  if ((*pickle_)[pickle_->root()].kind != PickleKind::dictionary)
    fail("{}: holds no dictionary of tensors", path.string());
}

void TorchFile::open_archive(ByteSpan content) {
  files_ = files_in_zip(content, path_, kPickleFile);
  text_ = files_->read(std::string(kPickleFile), kMaxPickleBytes);
  pickle_ = std::make_unique<Pickle>(text_, path_.string());
  storages_ = [files = files_.get()](const Pickle& pickle, PickleRef object) {
    const StorageId id = read_storage_id(pickle, object);
    constexpr std::uint64_t kMaxValues = std::uint64_t{1} << 32;
    if (id.count > kMaxValues)
      fail("{}: its pickle: a storage has {} values", pickle.source(), id.count);
    const std::uint64_t bytes = id.count * item_bytes(id.halves);
    TorchStorage storage{{}, id.halves, files->read("data/" + id.key, bytes)};
    storage.bytes = storage.owned;
    if (storage.owned.size() != bytes)
      fail("{}: cut off: storage {} has {} bytes instead of {}", pickle.source(), id.key,
           storage.owned.size(), bytes);
    return storage;
  };
}

void TorchFile::open_stream(ByteSpan content) {
  const std::string source = path_.string();
  ByteCursor cursor(content, source);
  pickle_ = std::make_unique<Pickle>(stream_object(content, cursor, source));
  storages_ = [found = read_storages(*pickle_, cursor, content, source)](const Pickle& pickle,
                                                                         PickleRef object) {
    return find_storage(found, read_storage_id(pickle, object).key, pickle.source());
  };
}

Tensor TorchFile::tensor(std::string_view name) const {
  const PickleRef object = pickle_->find(pickle_->root(), name);
  if (object == 0) fail("{}: has no tensor {}", path_.string(), name);
  return read_torch_tensor(*pickle_, object, storages_, std::string(name));
}

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
  for (std::size_t i = 0; i < tensors.size(); ++i)
    entries.push_back(
        {folder + "/data/" + std::to_string(i), bytes_of_floats(tensors[i].tensor.values)});
  entries.push_back({folder + "/version", "3\n"});
  write_zip(path, entries, ZipForm::stored);
}

}  // namespace qs
