// SPDX-License-Identifier: MIT
#include "io/tensor/pickle.h"

#include <algorithm>
#include <array>
#include <bit>
#include <map>

#include "base/fail.h"
#include "io/bytes/byte_cursor.h"
#include "io/bytes/byte_text.h"

namespace qs {
namespace {

constexpr std::size_t kMaxOperations = 1u << 20;
constexpr std::size_t kMaxMarks = 256;  // containers that are open at a time
constexpr std::size_t kMaxMemo = 1u << 18;
constexpr std::size_t kMaxItems = 1u << 21;  // sum over all containers
constexpr std::size_t kMaxLongBytes = 64;
constexpr int kMaxProtocol = 5;

enum class NameUse : std::uint8_t { called, made, mentioned };

struct KnownName {
  std::string_view name;
  NameUse use;  // as a function; as a class without arguments (NEWOBJ); only as an argument
};

constexpr std::string_view kOrderedDict = "collections.OrderedDict";

constexpr std::array kNames = {
    KnownName{kOrderedDict, NameUse::called},
    KnownName{"torch._utils._rebuild_tensor_v2", NameUse::called},
    KnownName{"torch._utils._rebuild_parameter", NameUse::called},
    KnownName{"torch.FloatStorage", NameUse::mentioned},
    KnownName{"torch.HalfStorage", NameUse::mentioned},
    KnownName{"torch.storage._load_from_bytes", NameUse::called},
    KnownName{"numpy.core.multiarray._reconstruct", NameUse::called},
    KnownName{"numpy._core.multiarray._reconstruct", NameUse::called},
    KnownName{"numpy.ndarray", NameUse::mentioned},
    KnownName{"numpy.dtype", NameUse::called},
    KnownName{"dahuffman.huffmancodec._EndOfFileSymbol", NameUse::made},
};

// The operations of all protocols that are refused, for messages. The codes and the names have the
// same order.
constexpr std::string_view kRefusedCodes =
    "012FILPSTUVdgilop\x82\x83\x84\x8b\x8d\x8f\x90\x91\x92\x96\x97\x98";
constexpr const char* kRefusedNames[] = {
    "POP",       "POP_MARK",    "DUP",         "FLOAT",          "INT",
    "LONG",      "PERSID",      "STRING",      "BINSTRING",      "SHORT_BINSTRING",
    "UNICODE",   "DICT",        "GET",         "INST",           "LIST",
    "OBJ",       "PUT",         "EXT1",        "EXT2",           "EXT4",
    "LONG4",     "BINUNICODE8", "EMPTY_SET",   "ADDITEMS",       "FROZENSET",
    "NEWOBJ_EX", "BYTEARRAY8",  "NEXT_BUFFER", "READONLY_BUFFER"};
static_assert(kRefusedCodes.size() == std::size(kRefusedNames));

// Index: PickleKind.
constexpr const char* kKindNames[] = {
    "None",    "a boolean", "an integer",   "an integer", "a real number", "a text",   "bytes",
    "a tuple", "a list",    "a dictionary", "a name",     "an object",     "a storage"};

const KnownName* find_name(std::string_view name) {
  const auto found = std::ranges::find(kNames, name, &KnownName::name);
  return found == kNames.end() ? nullptr : &*found;
}

const char* describe(PickleKind kind) { return kKindNames[static_cast<std::size_t>(kind)]; }

}  // namespace

/// The stack machine that a pickle is a program for.
class PickleMachine {
 public:
  explicit PickleMachine(Pickle& pickle)
      : pickle_(pickle), in_(pickle.content_, pickle.source_ + ": its pickle") {
    pickle_.objects_.emplace_back();  // "no object"
  }

  void run() {
    for (std::size_t operations = 0;; ++operations) {
      if (operations == kMaxOperations) refuse("it has more than {} operations", kMaxOperations);
      const auto code = in_.read<std::uint8_t>("an operation");
      if (code == '.') break;
      step(code);
    }
    pickle_.root_ = pop();
    pickle_.size_ = in_.offset();
    if (!stack_.empty() || !marks_.empty()) refuse("objects are left over at its end");
  }

 private:
  template <class... Args>
  [[noreturn]] void refuse(fmt::format_string<Args...> format, Args&&... args) const {
    fail("{}: its pickle: {}", pickle_.source_, fmt::format(format, std::forward<Args>(args)...));
  }

  void step(std::uint8_t code) {
    using M = PickleMachine;
    using Kind = PickleKind;
    struct Operation {
      std::uint8_t code;
      void (*run)(M& m);
    };
    static constexpr Operation kOperations[] = {
        {0x80, [](M& m) { m.check_protocol(); }},                                // PROTO
        {0x95, [](M& m) { m.check_frame(); }},                                   // FRAME
        {'(', [](M& m) { m.mark(); }},                                           // MARK
        {'q', [](M& m) { m.remember(m.in_.read<std::uint8_t>("a number")); }},   // BINPUT
        {'r', [](M& m) { m.remember(m.in_.read<std::uint32_t>("a number")); }},  // LONG_BINPUT
        {0x94, [](M& m) { m.remember(static_cast<std::uint32_t>(m.memo_.size())); }},  // MEMOIZE
        {'h', [](M& m) { m.recall(m.in_.read<std::uint8_t>("a number")); }},           // BINGET
        {'j', [](M& m) { m.recall(m.in_.read<std::uint32_t>("a number")); }},        // LONG_BINGET
        {'c', [](M& m) { m.push_global(); }},                                        // GLOBAL
        {0x93, [](M& m) { m.push_stack_global(); }},                                 // STACK_GLOBAL
        {'R', [](M& m) { m.reduce(); }},                                             // REDUCE
        {'b', [](M& m) { m.build(); }},                                              // BUILD
        {0x81, [](M& m) { m.new_object(); }},                                        // NEWOBJ
        {'Q', [](M& m) { m.push({.kind = Kind::persistent, .items = m.pop(1)}); }},  // BINPERSID
        {'}', [](M& m) { m.push({.kind = Kind::dictionary}); }},                     // EMPTY_DICT
        {']', [](M& m) { m.push({.kind = Kind::list}); }},                           // EMPTY_LIST
        {')', [](M& m) { m.push({.kind = Kind::tuple}); }},                          // EMPTY_TUPLE
        {'t', [](M& m) { m.push({.kind = Kind::tuple, .items = m.pop_to_mark()}); }},  // TUPLE
        {0x85, [](M& m) { m.push({.kind = Kind::tuple, .items = m.pop(1)}); }},        // TUPLE1
        {0x86, [](M& m) { m.push({.kind = Kind::tuple, .items = m.pop(2)}); }},        // TUPLE2
        {0x87, [](M& m) { m.push({.kind = Kind::tuple, .items = m.pop(3)}); }},        // TUPLE3
        {'s', [](M& m) { m.add(Kind::dictionary, m.pop(2)); }},                        // SETITEM
        {'u', [](M& m) { m.add(Kind::dictionary, m.pop_to_mark()); }},                 // SETITEMS
        {'a', [](M& m) { m.add(Kind::list, m.pop(1)); }},                              // APPEND
        {'e', [](M& m) { m.add(Kind::list, m.pop_to_mark()); }},                       // APPENDS
        {'N', [](M& m) { m.push({.kind = Kind::none}); }},                             // NONE
        {0x88, [](M& m) { m.push({.kind = Kind::boolean, .integer = 1}); }},           // NEWTRUE
        {0x89, [](M& m) { m.push({.kind = Kind::boolean, .integer = 0}); }},           // NEWFALSE
        {'J', [](M& m) { m.push_integer(m.in_.read<std::int32_t>("an integer")); }},   // BININT
        {'K', [](M& m) { m.push_integer(m.in_.read<std::uint8_t>("an integer")); }},   // BININT1
        {'M', [](M& m) { m.push_integer(m.in_.read<std::uint16_t>("an integer")); }},  // BININT2
        {0x8a, [](M& m) { m.push_long(m.in_.read<std::uint8_t>("a length")); }},       // LONG1
        {'G', [](M& m) { m.push_real(); }},                                            // BINFLOAT
        {'X', [](M& m) { m.push_text(m.in_.read<std::uint32_t>("a length")); }},       // BINUNICODE
        {0x8c,
         [](M& m) { m.push_text(m.in_.read<std::uint8_t>("a length")); }},  // SHORT_BINUNICODE
        {'C', [](M& m) { m.push_bytes(m.in_.read<std::uint8_t>("a length")); }},   // SHORT_BINBYTES
        {'B', [](M& m) { m.push_bytes(m.in_.read<std::uint32_t>("a length")); }},  // BINBYTES
        {0x8e, [](M& m) { m.push_bytes(m.in_.read<std::uint64_t>("a length")); }},  // BINBYTES8
    };
    const auto known = std::ranges::find(kOperations, code, &Operation::code);
    if (known != std::end(kOperations)) return known->run(*this);
    if (const auto at = kRefusedCodes.find(static_cast<char>(code)); at != kRefusedCodes.npos)
      refuse("the operation {} is not needed by any model and was refused", kRefusedNames[at]);
    refuse("the operation {:#04x} is unknown", code);
  }

  void check_protocol() {
    if (const int protocol = in_.read<std::uint8_t>("a protocol"); protocol > kMaxProtocol)
      refuse("protocol {} is unknown, {} is the newest known", protocol, kMaxProtocol);
  }

  void check_frame() {
    if (in_.read<std::uint64_t>("a frame") > in_.left()) refuse("a frame is cut off");
  }

  void mark() {
    if (marks_.size() == kMaxMarks) refuse("more than {} objects are nested", kMaxMarks);
    marks_.push_back(stack_.size());
  }

  void push_global() {
    const std::string_view module = line();
    push_name(module, line());
  }

  void push_stack_global() {
    const PickleRef name = pop(), module = pop();
    push_name(text_of(module), text_of(name));
  }

  void push_real() {
    std::uint64_t bits = 0;  // big endian
    for (const std::byte byte : in_.take(8, "a real number"))
      bits = bits << 8 | static_cast<std::uint64_t>(byte);
    push({.kind = PickleKind::real, .real = std::bit_cast<double>(bits)});
  }

  void push(PickleObject object) {
    count_items(object.items.size());
    stack_.push_back(static_cast<PickleRef>(pickle_.objects_.size()));
    pickle_.objects_.push_back(std::move(object));
  }

  void count_items(std::size_t items) {
    items_ += items;
    if (items_ > kMaxItems) refuse("its objects have more than {} items", kMaxItems);
  }

  void push_integer(std::int64_t value) { push({.kind = PickleKind::integer, .integer = value}); }

  void push_long(std::size_t size) {
    const auto bytes = in_.take(size, "an integer");
    if (size > kMaxLongBytes) refuse("an integer of {} bytes", size);
    if (size > sizeof(std::int64_t))
      return push({.kind = PickleKind::long_integer, .bytes = bytes});
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < size; ++i)
      value |= std::to_integer<std::uint64_t>(bytes[i]) << 8 * i;
    const bool negative = size > 0 && (bytes[size - 1] & std::byte{0x80}) != std::byte{0};
    if (negative && size < sizeof value) value |= ~std::uint64_t{0} << 8 * size;
    push_integer(static_cast<std::int64_t>(value));
  }

  void push_text(std::uint64_t size) {
    push({.kind = PickleKind::text, .text = qs::text_of(in_.take(size, "a text"))});
  }

  void push_bytes(std::uint64_t size) {
    push({.kind = PickleKind::bytes, .bytes = in_.take(size, "bytes")});
  }

  // Text up to the end of the line.
  std::string_view line() {
    const auto rest = pickle_.content_.subspan(in_.offset());
    const auto end = std::ranges::find(rest, std::byte{'\n'});
    if (end == rest.end()) refuse("a name is cut off");
    const auto size = static_cast<std::size_t>(end - rest.begin());
    in_.take(size + 1, "a name");
    return qs::text_of(rest.first(size));
  }

  std::string_view text_of(PickleRef object) const {
    return pickle_.text(object, "a part of a name");
  }

  void push_name(std::string_view module, std::string_view name) {
    if (const KnownName* const known = find_name(fmt::format("{}.{}", module, name)))
      return push({.kind = PickleKind::name, .text = known->name});
    refuse("the name {}.{} is not needed by any model and was refused", printable(module),
           printable(name));
  }

  // The known name that `object` is, if it may be used so.
  std::string_view used_name(PickleRef object, NameUse use) const {
    const PickleObject& name = pickle_[object];
    if (name.kind != PickleKind::name) refuse("{} is called", describe(name.kind));
    if (find_name(name.text)->use == use) return name.text;
    refuse("{} is called, but must only be mentioned", name.text);
  }

  void reduce() {
    const PickleRef arguments = pop();
    const std::string_view name = used_name(pop(), NameUse::called);
    if (pickle_[arguments].kind != PickleKind::tuple)
      refuse("the arguments of {} are not a tuple", name);
    if (name == kOrderedDict) {
      if (!pickle_[arguments].items.empty()) refuse("{} has arguments", name);
      return push({.kind = PickleKind::dictionary});
    }
    push({.kind = PickleKind::call, .text = name, .items = pickle_[arguments].items});
  }

  void new_object() {
    const PickleRef arguments = pop();
    const std::string_view name = used_name(pop(), NameUse::made);
    if (pickle_[arguments].kind != PickleKind::tuple || !pickle_[arguments].items.empty())
      refuse("{} has arguments", name);
    push({.kind = PickleKind::call, .text = name});
  }

  // The state of dictionaries (PyTorch's _metadata) does not matter.
  void build() {
    const PickleRef state = pop();
    PickleObject& object = top();
    if (object.kind == PickleKind::dictionary) return;
    if (object.kind != PickleKind::call) refuse("{} is given a state", describe(object.kind));
    object.state = state;
  }

  void add(PickleKind kind, const std::vector<PickleRef>& items) {
    PickleObject& container = top();
    if (container.kind != kind)
      refuse("items are added to {} instead of {}", describe(container.kind), describe(kind));
    if (kind == PickleKind::dictionary && items.size() % 2 != 0) refuse("a key has no value");
    count_items(items.size());
    container.items.insert(container.items.end(), items.begin(), items.end());
  }

  std::size_t bottom() const { return marks_.empty() ? 0 : marks_.back(); }

  PickleRef pop() { return pop(1).front(); }

  std::vector<PickleRef> pop(std::size_t count) {
    if (stack_.size() - bottom() < count) refuse("an operation lacks its operands");
    const auto begin = stack_.end() - static_cast<std::ptrdiff_t>(count);
    std::vector<PickleRef> objects(begin, stack_.end());
    stack_.erase(begin, stack_.end());
    return objects;
  }

  std::vector<PickleRef> pop_to_mark() {
    if (marks_.empty()) refuse("an operation lacks its mark");
    std::vector<PickleRef> objects = pop(stack_.size() - marks_.back());
    marks_.pop_back();
    return objects;
  }

  PickleObject& top() {
    if (stack_.size() == bottom()) refuse("an operation lacks its operands");
    return pickle_.objects_[stack_.back()];
  }

  void remember(std::uint32_t number) {
    top();
    if (memo_.size() == kMaxMemo) refuse("more than {} objects are remembered", kMaxMemo);
    memo_[number] = stack_.back();
  }

  void recall(std::uint32_t number) {
    const auto found = memo_.find(number);
    if (found == memo_.end()) refuse("object {} was not remembered", number);
    stack_.push_back(found->second);
  }

  Pickle& pickle_;
  ByteCursor in_;
  std::vector<PickleRef> stack_;
  std::vector<std::size_t> marks_;  // sizes of the stack
  std::map<std::uint32_t, PickleRef> memo_;
  std::size_t items_ = 0;
};

Pickle::Pickle(ByteSpan content, std::string source)
    : content_(content), source_(std::move(source)) {
  PickleMachine(*this).run();
}

const PickleObject& Pickle::expect(PickleKind kind, PickleRef object, const char* what) const {
  const PickleObject& found = objects_[object];
  if (found.kind == kind) return found;
  fail("{}: its pickle: {} is {} instead of {}", source_, what, describe(found.kind),
       describe(kind));
}

std::span<const PickleRef> Pickle::tuple(PickleRef object, std::size_t count,
                                         const char* what) const {
  const auto items = tuple(object, what);
  if (items.size() == count) return items;
  fail("{}: its pickle: {} has {} items instead of {}", source_, what, items.size(), count);
}

std::span<const PickleRef> Pickle::call(PickleRef object, std::string_view name, std::size_t count,
                                        const char* what) const {
  const PickleObject& found = objects_[object];
  if (found.kind == PickleKind::call && found.text == name && found.items.size() >= count)
    return found.items;
  fail("{}: its pickle: {} is {} instead of a result of {}", source_, what,
       found.kind == PickleKind::call ? printable(found.text) : describe(found.kind), name);
}

PickleRef Pickle::find(PickleRef dictionary, std::string_view key) const {
  const PickleObject& found = objects_[dictionary];
  if (found.kind != PickleKind::dictionary) return 0;
  // Of equal keys the last one counts.
  for (std::size_t i = found.items.size(); i >= 2; i -= 2) {
    const PickleObject& candidate = objects_[found.items[i - 2]];
    if (candidate.kind == PickleKind::text && candidate.text == key) return found.items[i - 1];
  }
  return 0;
}

}  // namespace qs
