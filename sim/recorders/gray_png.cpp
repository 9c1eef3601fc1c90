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

// Numbers of the deflate format (RFC 1951): symbol of the end of a block, number of symbols, and longest code [bits].
constexpr int kEndOfBlock = 256;
constexpr int kNumSymbols = 286;  // literals, end, lengths
constexpr int kMaxCodeBits = 15;
// [bytes] Shortest run of equal bytes that is coded as a run, and longest run of the format.
constexpr int kLeastRun = 4, kMostRun = 258;
constexpr std::uint16_t kRunToken = 256;  // larger tokens are runs of token - kRunToken repetitions

/// Code of a run length, RFC 1951, 3.2.5.
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
  return {257 + static_cast<int>(i), kExtra[i], kBase[i]};
}

/// Huffman code lengths of at most 15 bits.
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
    // Flatter counts give shorter codes.
    for (std::uint32_t& count : counts) count = count > 0 ? count / 2 + 1 : 0;
  }
}

/// Canonical codes, RFC 1951, 3.2.2; bit-reversed, since the stream is filled from the lowest bit.
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
    int turned = 0;
    for (int bit = 0; bit < lengths[i]; ++bit) turned |= (code >> bit & 1) << (lengths[i] - 1 - bit);
    codes[i] = static_cast<std::uint16_t>(turned);
  }
  return codes;
}

/// Fills bytes from the lowest bit. Writes eight bytes at a time, so the buffer must extend that far beyond the end.
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
static_assert(std::endian::native == std::endian::little, "bits are laid down as they stand in memory");

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

// Subtracts from each byte the byte two before in its row, which is the same half of the pixel to the left.
void filter(int width, int height, std::span<const std::uint16_t> gray, std::vector<std::uint8_t>& out) {
  out.resize((2U * static_cast<std::size_t>(width) + 1U) * static_cast<std::size_t>(height));
  std::uint8_t* at = out.data();
  for (int y = 0; y < height; ++y) {
    const std::uint16_t* const row = gray.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(width);
    *at++ = 1;  // Sub
    at[0] = static_cast<std::uint8_t>(row[0] >> 8);
    at[1] = static_cast<std::uint8_t>(row[0]);
    for (int x = 1; x < width; ++x) {
      at[2 * x] = static_cast<std::uint8_t>((row[x] >> 8) - (row[x - 1] >> 8));
      at[2 * x + 1] = static_cast<std::uint8_t>(row[x] - row[x - 1]);
    }
    at += 2 * width;
  }
}

// Splits the bytes into literals and runs of the previous byte.
void find_runs(std::span<const std::uint8_t> bytes, std::vector<std::uint16_t>& tokens) {
  tokens.resize(bytes.size());
  std::uint16_t* token = tokens.data();
  const std::size_t n = bytes.size();
  for (std::size_t i = 0; i < n;) {
    const std::uint8_t byte = bytes[i++];
    *token++ = byte;
    while (i + kLeastRun <= n && bytes[i] == byte) {
      std::size_t end = i;
      while (end < n && end - i < kMostRun && bytes[end] == byte) ++end;
      if (end - i < kLeastRun) break;
      *token++ = static_cast<std::uint16_t>(kRunToken + (end - i));
      i = end;
    }
  }
  tokens.resize(static_cast<std::size_t>(token - tokens.data()));
}

struct Bits {
  std::uint32_t bits = 0;
  int count = 0;
};
constexpr std::size_t kNumTokens = kRunToken + kMostRun + 1;
constexpr int kMostTokenBits = kMaxCodeBits + 5 + 1;  // length code, its extra bits, the distance

/// Bits for each token.
std::array<Bits, kNumTokens> bits_of_tokens(const std::array<std::uint8_t, kNumSymbols>& lengths) {
  const auto codes = codes_of(lengths);
  std::array<Bits, kNumTokens> table;
  for (std::size_t token = 0; token < kRunToken; ++token) table[token] = {codes[token], lengths[token]};
  for (int run = kLeastRun; run <= kMostRun; ++run) {
    const LengthCode code = length_code(run);
    const auto symbol = static_cast<std::size_t>(code.symbol);
    const auto extra = static_cast<std::uint32_t>(run - code.base);
    // The code, the difference to its base length, and one bit 0: distance 1.
    table[static_cast<std::size_t>(kRunToken + run)] = {codes[symbol] | extra << lengths[symbol],
                                                        lengths[symbol] + code.extra_bits + 1};
  }
  return table;
}

/// Frequency of each symbol of the code.
std::array<std::uint32_t, kNumSymbols> count_symbols(std::span<const std::uint16_t> tokens) {
  // Two tables: equal tokens often follow each other, and the second would wait for the first one's count.
  std::array<std::uint32_t, kNumTokens> even{}, odd{};
  std::size_t i = 0;
  for (; i + 1 < tokens.size(); i += 2) {
    ++even[tokens[i]];
    ++odd[tokens[i + 1]];
  }
  if (i < tokens.size()) ++even[tokens[i]];
  std::array<std::uint32_t, kNumSymbols> counts{};
  for (std::size_t token = 0; token < kRunToken; ++token) counts[token] = even[token] + odd[token];
  for (int run = kLeastRun; run <= kMostRun; ++run) {
    const auto token = static_cast<std::size_t>(kRunToken + run);
    counts[static_cast<std::size_t>(length_code(run).symbol)] += even[token] + odd[token];
  }
  counts[kEndOfBlock] = 1;
  return counts;
}

/// Writes one block with its own codes. @return one past the last byte
std::uint8_t* deflate_tokens(std::span<const std::uint16_t> tokens, std::uint8_t* out) {
  const auto lengths = code_lengths(count_symbols(tokens));
  BitWriter bits(out);
  bits.put(1, 1);                  // the last block
  bits.put(2, 2);                  // with dynamic codes
  bits.put(kNumSymbols - 257, 5);  // number of symbols
  bits.put(0, 5);                  // one distance code
  bits.put(19 - 4, 4);
  // The code lengths: 16 values of four bits each, no repetitions (order: 16, 17, 18, then 0 to 15 shuffled).
  for (int i = 0; i < 19; ++i) bits.put(i < 3 ? 0 : 4, 3);
  const auto put_length = [&](int length) {
    const int turned = (length & 1) << 3 | (length & 2) << 1 | (length & 4) >> 1 | (length & 8) >> 3;
    bits.put(static_cast<std::uint32_t>(turned), 4);
  };
  for (const std::uint8_t length : lengths) put_length(length);
  put_length(1);
  const auto table = bits_of_tokens(lengths);
  // Two at a time, which shortens the dependency chain through the write position.
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

/// Upper bound of the size of a block with this number of tokens, including header, checksum and BitWriter's margin.
std::size_t room_for(std::size_t num_tokens) { return num_tokens * kMostTokenBits / 8 + 1024; }

}  // namespace

const ByteBuffer& GrayPng::encode(int width, int height, std::span<const std::uint16_t> gray) {
  if (width <= 0 || height <= 0 || gray.size() != static_cast<std::size_t>(width) * static_cast<std::size_t>(height)) {
    throw std::invalid_argument("a picture's size and data do not agree");
  }
  filter(width, height, gray, filtered_);
  find_runs(filtered_, tokens_);
  if (stream_.size() < room_for(tokens_.size())) stream_.resize(room_for(tokens_.size()));
  stream_[0] = 0x78;
  stream_[1] = 0x01;
  std::uint8_t* end = deflate_tokens(tokens_, stream_.data() + 2);
  const auto check = static_cast<std::uint32_t>(adler32(1, filtered_.data(), static_cast<uInt>(filtered_.size())));
  for (int shift = 24; shift >= 0; shift -= 8) *end++ = static_cast<std::uint8_t>(check >> shift);

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
