// SPDX-License-Identifier: MIT
#include "io/scene/compact/huffman.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <map>
#include <queue>

#include "base/fail.h"
#include "base/list_of.h"
#include "io/bytes/byte_cursor.h"
#include "io/bytes/byte_text.h"

namespace qs {

namespace {

constexpr int kMaxBits = 64;
constexpr std::string_view kEndName = "dahuffman.huffmancodec._EndOfFileSymbol";

// NumPy counts in doubles, so whole numbers are reals there.
std::uint32_t symbol_of(const PickleObject& object, const std::string& source) {
  if (object.kind == PickleKind::call && object.text == kEndName) return kHuffmanEnd;
  const bool is_number = object.kind == PickleKind::real || object.kind == PickleKind::integer;
  const double value =
      object.kind == PickleKind::real ? object.real : static_cast<double>(object.integer);
  if (!is_number || !(value >= 0 && value < kHuffmanEnd && value == std::floor(value)))
    fail("{}: a symbol of its table is no whole number from 0 to {}", source, kHuffmanEnd - 1);
  return static_cast<std::uint32_t>(value);
}

// The bits of a stream, highest first, as a window of 64 of them; zeros follow the end.
class BitWindow {
 public:
  explicit BitWindow(ByteSpan bytes) : bytes_(bytes) {}

  // The next `bits` bits, at most 32, without reading them.
  std::uint32_t peek(int bits) {
    while (ready_ <= 56) {
      const std::uint64_t byte =
          next_ < bytes_.size() ? std::to_integer<std::uint64_t>(bytes_[next_]) : 0;
      window_ |= byte << (56 - ready_);
      ready_ += 8;
      ++next_;
    }
    return static_cast<std::uint32_t>(window_ >> (64 - bits));
  }

  // Reads bits that were peeked at.
  void skip(int bits) {
    window_ <<= bits;
    ready_ -= bits;
    read_ += static_cast<std::uint64_t>(bits);
  }

  std::uint64_t read() const { return read_; }

 private:
  ByteSpan bytes_;
  std::size_t next_ = 0;
  std::uint64_t window_ = 0, read_ = 0;
  int ready_ = 0;
};

}  // namespace

std::vector<HuffmanCode> read_huffman_table(const Pickle& pickle, PickleRef table,
                                            const std::string& source) {
  const PickleObject& dictionary = pickle[table];
  if (dictionary.kind != PickleKind::dictionary) fail("{}: its table is no dictionary", source);
  std::map<std::uint32_t, HuffmanCode> codes;  // the last one of equal keys counts
  for (std::size_t i = 0; i + 1 < dictionary.items.size(); i += 2) {
    HuffmanCode code;
    code.symbol = symbol_of(pickle[dictionary.items[i]], source);
    const auto pair = pickle.tuple(dictionary.items[i + 1], 2, "a code");
    const std::int64_t bits = pickle.integer(pair[0], "the number of bits of a code");
    const std::int64_t value = pickle.integer(pair[1], "the value of a code");
    if (bits < 1 || bits >= kMaxBits || value < 0 || value >> bits != 0)
      fail("{}: its table has the code {} of {} bits", source, value, bits);
    code.bits = static_cast<int>(bits);
    code.value = static_cast<std::uint64_t>(value);
    codes[code.symbol] = code;
  }
  if (codes.empty()) fail("{}: its table is empty", source);
  return list_of<HuffmanCode>(codes, [](const auto& each) { return each.second; });
}

std::vector<HuffmanCode> make_huffman_table(std::span<const std::uint64_t> counts) {
  struct Tree {
    std::uint64_t count;
    std::size_t number;  // counts the trees; it orders equal counts
    std::vector<HuffmanCode> codes;
    bool operator<(const Tree& other) const {  // the queue's top is its largest element
      return count != other.count ? count > other.count : number > other.number;
    }
  };
  std::priority_queue<Tree> trees;
  for (std::size_t symbol = 0; symbol < counts.size(); ++symbol)
    if (counts[symbol] > 0)
      trees.push({counts[symbol], symbol, {{static_cast<std::uint32_t>(symbol), 0, 0}}});
  trees.push({1, counts.size(), {{kHuffmanEnd, 0, 0}}});
  if (trees.size() == 1) return {{kHuffmanEnd, 1, 0}};
  const auto pop = [&trees] {
    Tree tree = trees.top();
    trees.pop();
    return tree;
  };
  for (std::size_t number = counts.size() + 1; trees.size() > 1; ++number) {
    Tree zero = pop();
    const Tree one = pop();
    for (HuffmanCode& code : zero.codes) ++code.bits;
    for (HuffmanCode code : one.codes) {
      code.value |= std::uint64_t{1} << code.bits++;
      zero.codes.push_back(code);
    }
    trees.push({zero.count + one.count, number, std::move(zero.codes)});
  }
  return trees.top().codes;
}

std::vector<std::byte> huffman_encode(std::span<const HuffmanCode> table,
                                      std::span<const std::uint16_t> symbols) {
  std::vector<HuffmanCode> by_symbol(kHuffmanEnd + 1);
  for (const HuffmanCode& code : table) by_symbol[code.symbol] = code;
  std::vector<std::byte> stream;
  unsigned byte = 1;  // the bits so far, below a one
  const auto put = [&](const HuffmanCode& code, bool whole) {
    for (int bit = code.bits; bit-- > 0 && (whole || byte != 1);) {
      byte = byte << 1 | static_cast<unsigned>(code.value >> bit & 1);
      if (byte < 0x100) continue;
      stream.push_back(static_cast<std::byte>(byte & 0xff));
      byte = 1;
    }
  };
  for (const std::uint16_t symbol : symbols) put(by_symbol[symbol], true);
  put(by_symbol[kHuffmanEnd], false);
  for (; byte != 1; byte = byte < 0x100 ? byte << 1 : 1) {  // the end symbol was too short
    if (byte >= 0x100) stream.push_back(static_cast<std::byte>(byte & 0xff));
  }
  return stream;
}

HuffmanDecoder::HuffmanDecoder(std::span<const HuffmanCode> table, std::string source)
    : source_(std::move(source)), nodes_(1), fast_(std::size_t{1} << kFastBits) {
  for (const HuffmanCode& code : table) insert(code);
  fill_fast();
}

void HuffmanDecoder::insert(const HuffmanCode& code) {
  std::uint32_t node = 0;
  for (int bit = code.bits; bit-- > 0;) {
    const std::size_t side = code.value >> bit & 1;
    const std::uint32_t child = nodes_[node][side];
    const bool taken = bit == 0 ? child != 0 : (child & kLeaf) != 0;
    if (taken) fail("{}: a code of its table is the beginning of another one", source_);
    if (bit == 0) {
      nodes_[node][side] = kLeaf | code.symbol;
    } else if (child == 0) {
      const auto added = static_cast<std::uint32_t>(nodes_.size());
      nodes_.emplace_back();
      nodes_[node][side] = added;
      node = added;
    } else {
      node = child;
    }
  }
}

void HuffmanDecoder::fill_fast() {
  for (std::size_t prefix = 0; prefix < fast_.size(); ++prefix) {
    Step step;
    std::uint32_t node = 0;
    for (int bit = kFastBits; bit-- > 0;) {
      node = nodes_[node][prefix >> bit & 1];
      ++step.bits;
      if (node == 0 || (node & kLeaf) != 0) break;
    }
    step.to = node;
    fast_[prefix] = step;
  }
}

Array<std::uint16_t> HuffmanDecoder::decode(ByteSpan stream, std::uint64_t most) const {
  const std::uint64_t bits = stream.size() * 8;
  Array<std::uint16_t> symbols;
  symbols.reserve(std::min(bits, most));
  BitWindow window(stream);
  std::uint64_t end = 0;  // bits up to the end of the last symbol
  while (end < bits) {
    Step step = fast_[window.peek(kFastBits)];
    window.skip(step.bits);
    while ((step.to & kLeaf) == 0 && step.to != 0 && window.read() < bits) {
      step.to = nodes_[step.to][window.peek(1)];
      window.skip(1);
    }
    if (window.read() > bits || (step.to & kLeaf) == 0) {
      // The end symbol's first bits fill less than a byte.
      if (bits - end < 8 && (window.read() >= bits)) break;
      fail("{}: the bits behind its {} symbols are not in its table", source_, symbols.size());
    }
    end = window.read();
    const std::uint32_t symbol = step.to & ~kLeaf;
    if (symbol == kHuffmanEnd) break;
    if (symbols.size() == most) fail("{}: has more than {} symbols", source_, most);
    symbols.push_back(static_cast<std::uint16_t>(symbol));
  }
  if (end <= bits && bits - end >= 8)
    fail("{}: {} bytes follow its {} symbols", source_, (bits - end) / 8, symbols.size());
  return symbols;
}

Array<std::uint16_t> unpack_bits(ByteSpan packed, std::size_t count, int bits) {
  assert(packed.size() >= packed_bytes(count, bits));
  Array<std::uint16_t> numbers(count);
  std::size_t next = 0;
  for (std::uint16_t& number : numbers) {
    unsigned value = 0;
    for (int bit = 0; bit < bits; ++bit, ++next) {
      const unsigned set = std::to_integer<unsigned>(packed[next / 8]) >> (7 - next % 8) & 1;
      value |= set << bit;
    }
    number = static_cast<std::uint16_t>(value);
  }
  return numbers;
}

std::vector<std::byte> pack_bits(std::span<const std::uint16_t> numbers, int bits) {
  std::vector<std::byte> packed(packed_bytes(numbers.size(), bits));
  std::size_t next = 0;
  for (const std::uint16_t number : numbers)
    for (int bit = 0; bit < bits; ++bit, ++next)
      if ((number >> bit & 1) != 0)
        packed[next / 8] |= std::byte{0x80} >> static_cast<int>(next % 8);
  return packed;
}

}  // namespace qs
