// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/recorders/gray_png.hpp"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <queue>
#include <stdexcept>
#include <string_view>

namespace swiftlet::sim {
namespace {

// Symbols of the deflate format (RFC 1951): 256 literals, the end of the block, and the lengths of repetitions.
constexpr int kEndOfBlock = 256;
constexpr int kFirstLength = 257;
constexpr int kNumSymbols = 286;
constexpr int kMaxCodeBits = 15;     // longest Huffman code of the format
constexpr int kNumLengthCodes = 19;  // symbols with which the format writes the lengths of the Huffman codes
// [bytes] Shortest repetition of a byte that is coded as such, and longest repetition of the format. Smaller values of
// kMinRun replace literals whose codes are shorter.
constexpr int kMinRun = 4, kMaxRun = 258;
// A token below this value is a literal byte; kRunToken + n repeats the previous byte n times.
constexpr std::uint16_t kRunToken = 256;
// [bytes] Space for the headers, the checksum and BitWriter's margin, in addition to the coded tokens.
constexpr std::size_t kOverhead_bytes = 1024;
constexpr std::uint8_t kFilterSub = 1;  // PNG filter type: difference from the pixel to the left
// Header of the zlib format: deflate with a window of 32 KiB, no dictionary.
constexpr std::uint8_t kZlibHeader[] = {0x78, 0x01};

/// Code of a repetition length (RFC 1951, 3.2.5): the symbol of a range of lengths that begins at `base`, followed by
/// the difference length - base in `extra_bits` bits.
struct LengthCode {
  int symbol, extra_bits, base;
};
LengthCode length_code(int length) {
  static constexpr std::array<int, 29> kBase = {3,  4,  5,  6,  7,  8,  9,  10, 11,  13,  15,  17,  19,  23, 27,
                                                31, 35, 43, 51, 59, 67, 83, 99, 115, 131, 163, 195, 227, 258};
  static constexpr std::array<int, 29> kExtra = {0, 0, 0, 0, 0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2,
                                                 2, 3, 3, 3, 3, 4, 4, 4, 4, 5, 5, 5, 5, 0};
  std::size_t i = kBase.size() - 1;
  while (kBase[i] > length) --i;
  return {kFirstLength + static_cast<int>(i), kExtra[i], kBase[i]};
}

/// Length of the Huffman code of each symbol [bits], at most kMaxCodeBits, from the frequencies of the symbols.
std::array<std::uint8_t, kNumSymbols> code_lengths(std::array<std::uint32_t, kNumSymbols> counts) {
  struct Node {
    std::uint64_t count;
    int index;
    bool operator<(const Node& other) const { return count != other.count ? count > other.count : index > other.index; }
  };
  for (;;) {
    std::array<int, 2 * kNumSymbols> parent{};
    std::priority_queue<Node> open;
    for (int i = 0; i < kNumSymbols; ++i) {
      if (counts[static_cast<std::size_t>(i)] > 0) open.push({counts[static_cast<std::size_t>(i)], i});
    }
    int next = kNumSymbols;
    while (open.size() > 1) {
      const Node a = open.top();
      open.pop();
      const Node b = open.top();
      open.pop();
      parent[static_cast<std::size_t>(a.index)] = parent[static_cast<std::size_t>(b.index)] = next;
      open.push({a.count + b.count, next++});
    }
    const int root = open.top().index;
    std::array<std::uint8_t, kNumSymbols> lengths{};
    int longest = 0;
    for (int i = 0; i < kNumSymbols; ++i) {
      if (counts[static_cast<std::size_t>(i)] == 0) continue;
      int length = 0;
      for (int node = i; node != root; node = parent[static_cast<std::size_t>(node)]) ++length;
      lengths[static_cast<std::size_t>(i)] = static_cast<std::uint8_t>(length);
      longest = std::max(longest, length);
    }
    if (longest <= kMaxCodeBits) return lengths;
    // Halved frequencies differ less, so the longest code becomes shorter.
    for (std::uint32_t& count : counts) count = count > 0 ? count / 2 + 1 : 0;
  }
}

/// Canonical Huffman codes (RFC 1951, 3.2.2), with reversed bits, because the stream is filled from the lowest bit.
std::array<std::uint16_t, kNumSymbols> codes_of(const std::array<std::uint8_t, kNumSymbols>& lengths) {
  std::array<int, kMaxCodeBits + 2> first{};
  for (const std::uint8_t length : lengths) {
    if (length > 0) ++first[length + 1U];
  }
  for (std::size_t bits = 2; bits < first.size(); ++bits) first[bits] = (first[bits] + first[bits - 1]) << 1;
  std::array<std::uint16_t, kNumSymbols> codes{};
  for (std::size_t i = 0; i < lengths.size(); ++i) {
    if (lengths[i] == 0) continue;
    const int code = first[lengths[i]]++;
    int reversed = 0;
    for (int bit = 0; bit < lengths[i]; ++bit) reversed |= (code >> bit & 1) << (lengths[i] - 1 - bit);
    codes[i] = static_cast<std::uint16_t>(reversed);
  }
  return codes;
}

/// Writes a stream of bits, filling each byte from its lowest bit. Each call writes eight bytes, so the buffer must
/// extend eight bytes beyond the end of the stream.
class BitWriter {
 public:
  explicit BitWriter(std::uint8_t* at) : at_(at) {}
  /// Appends at most 56 bits.
  void put(std::uint64_t bits, int count) {
    held_ |= bits << num_held_;
    num_held_ += count;
    std::memcpy(at_, &held_, sizeof held_);
    at_ += num_held_ >> 3;
    held_ >>= num_held_ & ~7;
    num_held_ &= 7;
  }
  /// @return one past the last byte
  std::uint8_t* finish() {
    if (num_held_ > 0) put(0, 8 - num_held_);
    return at_;
  }

 private:
  std::uint8_t* at_;
  std::uint64_t held_ = 0;
  int num_held_ = 0;
};
static_assert(std::endian::native == std::endian::little, "BitWriter copies its bits from memory");

void put_big_endian(ByteBuffer& out, std::uint32_t value) {
  for (int shift = 24; shift >= 0; shift -= 8) out.put(static_cast<std::uint8_t>(value >> shift));
}

void put_chunk(ByteBuffer& out, std::string_view kind, std::span<const std::uint8_t> content) {
  put_big_endian(out, static_cast<std::uint32_t>(content.size()));
  const std::size_t start = out.size();
  out.put_text(kind);
  out.put_bytes(std::as_bytes(content));
  const auto covered = out.bytes_from(start);
  put_big_endian(out, static_cast<std::uint32_t>(
                          crc32(0, reinterpret_cast<const Bytef*>(covered.data()), static_cast<uInt>(covered.size()))));
}

// PNG filter Sub on pixels of two bytes, the high one first: replaces each byte by its difference from the same byte of
// the pixel to the left. Each row begins with the number of the filter.
void filter(int width, int height, std::span<const std::uint16_t> gray, std::vector<std::uint8_t>& out) {
  out.resize((2U * static_cast<std::size_t>(width) + 1U) * static_cast<std::size_t>(height));
  std::uint8_t* at = out.data();
  for (int y = 0; y < height; ++y) {
    const std::uint16_t* const row = gray.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(width);
    *at++ = kFilterSub;
    at[0] = static_cast<std::uint8_t>(row[0] >> 8);
    at[1] = static_cast<std::uint8_t>(row[0]);
    for (int x = 1; x < width; ++x) {
      at[2 * x] = static_cast<std::uint8_t>((row[x] >> 8) - (row[x - 1] >> 8));
      at[2 * x + 1] = static_cast<std::uint8_t>(row[x] - row[x - 1]);
    }
    at += 2 * width;
  }
}

// Converts the bytes to tokens: literal bytes, and repetitions of the previous byte.
void find_runs(std::span<const std::uint8_t> bytes, std::vector<std::uint16_t>& tokens) {
  tokens.resize(bytes.size());
  std::uint16_t* token = tokens.data();
  const std::size_t n = bytes.size();
  for (std::size_t i = 0; i < n;) {
    const std::uint8_t byte = bytes[i++];
    *token++ = byte;
    while (i + kMinRun <= n && bytes[i] == byte) {
      std::size_t end = i;
      while (end < n && end - i < kMaxRun && bytes[end] == byte) ++end;
      if (end - i < kMinRun) break;
      *token++ = static_cast<std::uint16_t>(kRunToken + (end - i));
      i = end;
    }
  }
  tokens.resize(static_cast<std::size_t>(token - tokens.data()));
}

/// A sequence of bits in the order of the stream, the first one lowest.
struct Bits {
  std::uint32_t bits = 0;
  int count = 0;
};
constexpr std::size_t kNumTokens = kRunToken + kMaxRun + 1;
constexpr int kMaxTokenBits = kMaxCodeBits + 5 + 1;  // code of a length, its extra bits, code of the distance

/// Bits of each token in the stream.
std::array<Bits, kNumTokens> bits_of_tokens(const std::array<std::uint8_t, kNumSymbols>& lengths) {
  const auto codes = codes_of(lengths);
  std::array<Bits, kNumTokens> table;
  for (std::size_t token = 0; token < kRunToken; ++token) table[token] = {codes[token], lengths[token]};
  for (int run = kMinRun; run <= kMaxRun; ++run) {
    const LengthCode code = length_code(run);
    const auto symbol = static_cast<std::size_t>(code.symbol);
    const auto extra = static_cast<std::uint32_t>(run - code.base);
    // Code of the length, its extra bits, and a bit 0: the code of distance 1, the only one in use.
    table[static_cast<std::size_t>(kRunToken + run)] = {codes[symbol] | extra << lengths[symbol],
                                                        lengths[symbol] + code.extra_bits + 1};
  }
  return table;
}

/// Frequency of each symbol in the tokens and the end of the block.
std::array<std::uint32_t, kNumSymbols> count_symbols(std::span<const std::uint16_t> tokens) {
  // Even and odd positions are counted separately: consecutive tokens are often equal, and with one table each
  // increment would wait for the previous one.
  std::array<std::uint32_t, kNumTokens> even{}, odd{};
  std::size_t i = 0;
  for (; i + 1 < tokens.size(); i += 2) {
    ++even[tokens[i]];
    ++odd[tokens[i + 1]];
  }
  if (i < tokens.size()) ++even[tokens[i]];
  std::array<std::uint32_t, kNumSymbols> counts{};
  for (std::size_t token = 0; token < kRunToken; ++token) counts[token] = even[token] + odd[token];
  for (int run = kMinRun; run <= kMaxRun; ++run) {
    const auto token = static_cast<std::size_t>(kRunToken + run);
    counts[static_cast<std::size_t>(length_code(run).symbol)] += even[token] + odd[token];
  }
  counts[kEndOfBlock] = 1;
  return counts;
}

/// Writes one deflate block with dynamic Huffman codes (RFC 1951, 3.2.7). @return one past the last byte
std::uint8_t* deflate_tokens(std::span<const std::uint16_t> tokens, std::uint8_t* out) {
  const auto lengths = code_lengths(count_symbols(tokens));
  BitWriter bits(out);
  bits.put(1, 1);                           // BFINAL: the last block
  bits.put(2, 2);                           // BTYPE: dynamic codes
  bits.put(kNumSymbols - kFirstLength, 5);  // HLIT: number of symbols, less 257
  bits.put(0, 5);                           // HDIST: number of distance codes, less 1
  bits.put(kNumLengthCodes - 4, 4);         // HCLEN: number of symbols for code lengths, less 4
  // Code lengths 0 to 15 are written in four bits each. The symbols 16, 17 and 18 for repeated lengths, which come
  // first, are unused.
  for (int i = 0; i < kNumLengthCodes; ++i) bits.put(i < 3 ? 0 : 4, 3);
  const auto put_length = [&](int length) {
    const int reversed = (length & 1) << 3 | (length & 2) << 1 | (length & 4) >> 1 | (length & 8) >> 3;
    bits.put(static_cast<std::uint32_t>(reversed), 4);
  };
  for (const std::uint8_t length : lengths) put_length(length);
  put_length(1);  // the distance code
  const auto table = bits_of_tokens(lengths);
  // Two tokens per call of put(), because each call waits for the write position of the previous one.
  std::size_t i = 0;
  for (; i + 1 < tokens.size(); i += 2) {
    const Bits first = table[tokens[i]], second = table[tokens[i + 1]];
    bits.put(first.bits | static_cast<std::uint64_t>(second.bits) << first.count, first.count + second.count);
  }
  if (i < tokens.size()) bits.put(table[tokens[i]].bits, table[tokens[i]].count);
  const auto codes = codes_of(lengths);
  bits.put(codes[kEndOfBlock], lengths[kEndOfBlock]);
  return bits.finish();
}

/// [bytes] Buffer size that is sufficient for the zlib stream of this number of tokens.
std::size_t room_for(std::size_t num_tokens) { return num_tokens * kMaxTokenBits / 8 + kOverhead_bytes; }

}  // namespace

const ByteBuffer& GrayPng::encode(int width, int height, std::span<const std::uint16_t> gray) {
  if (width <= 0 || height <= 0 || gray.size() != static_cast<std::size_t>(width) * static_cast<std::size_t>(height)) {
    throw std::invalid_argument("GrayPng::encode: expected width * height pixels, both greater than 0");
  }
  filter(width, height, gray, filtered_);
  find_runs(filtered_, tokens_);
  if (stream_.size() < room_for(tokens_.size())) stream_.resize(room_for(tokens_.size()));
  std::copy(std::begin(kZlibHeader), std::end(kZlibHeader), stream_.begin());
  std::uint8_t* end = deflate_tokens(tokens_, stream_.data() + std::size(kZlibHeader));
  const auto checksum = static_cast<std::uint32_t>(adler32(1, filtered_.data(), static_cast<uInt>(filtered_.size())));
  for (int shift = 24; shift >= 0; shift -= 8) *end++ = static_cast<std::uint8_t>(checksum >> shift);

  file_.clear();
  file_.put_text("\x89PNG\r\n\x1a\n");
  ByteBuffer header;
  put_big_endian(header, static_cast<std::uint32_t>(width));
  put_big_endian(header, static_cast<std::uint32_t>(height));
  for (const int value : {16, 0, 0, 0, 0})
    header.put(static_cast<std::uint8_t>(value));  // bit depth, gray, deflate, filters, not interlaced
  put_chunk(file_, "IHDR", {reinterpret_cast<const std::uint8_t*>(header.bytes().data()), header.size()});
  put_chunk(file_, "IDAT", {stream_.data(), end});
  put_chunk(file_, "IEND", {});
  return file_;
}

}  // namespace swiftlet::sim
