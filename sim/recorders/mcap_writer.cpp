// SPDX-License-Identifier: BSD-3-Clause
#include "sim/recorders/mcap_writer.hpp"

#include <zlib.h>
#include <zstd.h>

#include <algorithm>
#include <stdexcept>

namespace swiftlet::sim {
namespace {

enum Opcode : std::uint8_t {
  kHeader = 0x01,
  kFooter = 0x02,
  kSchema = 0x03,
  kChannel = 0x04,
  kMessage = 0x05,
  kChunk = 0x06,
  kMessageIndex = 0x07,
  kChunkIndex = 0x08,
  kStatistics = 0x0B,
  kSummaryOffset = 0x0E,
  kDataEnd = 0x0F,
};

constexpr std::uint8_t kMagic[] = {0x89, 'M', 'C', 'A', 'P', 0x30, '\r', '\n'};

std::span<const std::byte> magic() { return std::as_bytes(std::span(kMagic)); }

void put_string(std::string_view text, ByteBuffer& out) {
  out.put(static_cast<std::uint32_t>(text.size()));
  out.put_text(text);
}

/// Appends the output of `content`, preceded by its length as a Length.
template <class Length, class Content>
void put_sized(ByteBuffer& out, Content content) {
  const std::size_t start = out.size();
  out.put(Length{0});
  content();
  out.put_at(start, static_cast<Length>(out.size() - start - sizeof(Length)));
}

template <class Content>
void put_record(Opcode opcode, ByteBuffer& out, Content content) {
  out.put(static_cast<std::uint8_t>(opcode));
  put_sized<std::uint64_t>(out, content);
}

std::uint32_t crc_of(std::span<const std::byte> bytes, std::uint32_t before = 0) {
  return static_cast<std::uint32_t>(::crc32_z(before, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
}

}  // namespace

struct McapWriter::Compressor {
  ZSTD_CCtx* context = ZSTD_createCCtx();
  ~Compressor() { ZSTD_freeCCtx(context); }
};

McapWriter::McapWriter(const std::filesystem::path& path, Options options)
    : options_(std::move(options)), file_(path), compressor_(std::make_unique<Compressor>()) {
  record_.put_bytes(magic());
  put_record(kHeader, record_, [&] {
    put_string(options_.profile, record_);
    put_string(options_.library, record_);
  });
  append(record_);
}

McapWriter::~McapWriter() = default;

std::uint16_t McapWriter::add_channel(Channel channel) {
  ChannelState state{std::move(channel), 0, 0, {}};
  const auto known = std::find(schemas_.begin(), schemas_.end(), state.channel.schema_name);
  state.schema_id = static_cast<std::uint16_t>(known - schemas_.begin() + 1);
  if (known == schemas_.end()) {
    schemas_.push_back(state.channel.schema_name);
    put_schema(state, chunk_);
  }
  channels_.push_back(std::move(state));
  const auto id = static_cast<std::uint16_t>(channels_.size());
  put_channel(id, chunk_);
  return id;
}

void McapWriter::write(std::uint16_t channel, std::uint32_t sequence, TimeNs t, std::span<const std::byte> message) {
  ChannelState& state = channels_.at(channel - 1U);
  const bool first = std::all_of(channels_.begin(), channels_.end(), [](const auto& c) { return c.index.empty(); });
  chunk_start_ = first ? t : std::min(chunk_start_, t);
  chunk_end_ = first ? t : std::max(chunk_end_, t);
  state.index.put(static_cast<std::uint64_t>(t));
  state.index.put(static_cast<std::uint64_t>(chunk_.size()));
  ++state.num_messages;
  put_record(kMessage, chunk_, [&] {
    chunk_.put(channel);
    chunk_.put(sequence);
    chunk_.put(static_cast<std::uint64_t>(t));  // log time
    chunk_.put(static_cast<std::uint64_t>(t));  // publish time
    chunk_.put_bytes(message);
  });
  if (chunk_.size() >= options_.chunk_bytes) close_chunk();
}

void McapWriter::close_chunk() {
  if (chunk_.empty()) return;
  ChunkIndex index{chunk_start_, chunk_end_, file_.size(), 0, {}, 0, 0, chunk_.size()};
  const std::span<const std::byte> records = compressed_chunk();
  index.compressed_size = records.size();

  record_.clear();
  record_.put(static_cast<std::uint8_t>(kChunk));
  const std::size_t length_at = record_.size();
  record_.put(std::uint64_t{0});
  record_.put(static_cast<std::uint64_t>(chunk_start_));
  record_.put(static_cast<std::uint64_t>(chunk_end_));
  record_.put(static_cast<std::uint64_t>(chunk_.size()));
  record_.put(crc_of(chunk_.bytes()));
  put_string(options_.compress ? "zstd" : "", record_);
  record_.put(static_cast<std::uint64_t>(records.size()));
  index.length = record_.size() + records.size();
  record_.put_at(length_at, index.length - length_at - sizeof(std::uint64_t));
  append(record_);
  crc_ = crc_of(records, crc_);
  file_.append(records);

  // Offsets of each channel's messages in the chunk.
  record_.clear();
  const std::uint64_t indexes_at = file_.size();
  for (std::size_t i = 0; i < channels_.size(); ++i) {
    ByteBuffer& entries = channels_[i].index;
    if (entries.empty()) continue;
    const auto id = static_cast<std::uint16_t>(i + 1);
    index.index_offsets.emplace_back(id, indexes_at + record_.size());
    put_record(kMessageIndex, record_, [&] {
      record_.put(id);
      put_sized<std::uint32_t>(record_, [&] { record_.put_bytes(entries.bytes()); });
    });
    entries.clear();
  }
  index.index_length = record_.size();
  append(record_);
  chunks_.push_back(std::move(index));
  chunk_.clear();
  chunk_start_ = chunk_end_ = 0;
}

std::span<const std::byte> McapWriter::compressed_chunk() {
  if (!options_.compress) return chunk_.bytes();
  compressed_.resize(ZSTD_compressBound(chunk_.size()));
  const std::size_t size = ZSTD_compressCCtx(compressor_->context, compressed_.data(), compressed_.size(),
                                             chunk_.bytes().data(), chunk_.size(), options_.zstd_level);
  if (ZSTD_isError(size)) {
    throw std::runtime_error("cannot write " + file_.path().string() + ": zstd: " + ZSTD_getErrorName(size));
  }
  return std::span(compressed_).first(size);
}

void McapWriter::finish() {
  close_chunk();
  record_.clear();
  put_record(kDataEnd, record_, [&] { record_.put(crc_); });
  append(record_);
  record_.clear();
  put_summary(record_);
  record_.put_bytes(magic());
  append(record_);
  file_.finish();
}

void McapWriter::put_summary(ByteBuffer& out) const {
  const std::uint64_t summary_at = file_.size();
  struct Group {
    Opcode opcode;
    std::uint64_t start, length;
  };
  std::vector<Group> groups;
  const auto put_group = [&](Opcode opcode, auto content) {
    const std::uint64_t start = out.size();
    content();
    if (out.size() > start) groups.push_back({opcode, summary_at + start, out.size() - start});
  };
  put_group(kSchema, [&] {
    for (std::size_t id = 1; id <= schemas_.size(); ++id) {
      put_schema(*std::find_if(channels_.begin(), channels_.end(), [&](const auto& c) { return c.schema_id == id; }),
                 out);
    }
  });
  put_group(kChannel, [&] {
    for (std::size_t id = 1; id <= channels_.size(); ++id) put_channel(static_cast<std::uint16_t>(id), out);
  });
  put_group(kStatistics, [&] { put_statistics(out); });
  put_group(kChunkIndex, [&] {
    for (const ChunkIndex& index : chunks_) put_chunk_index(index, out);
  });
  const std::uint64_t offsets_at = summary_at + out.size();
  for (const Group& group : groups) {
    put_record(kSummaryOffset, out, [&] {
      out.put(static_cast<std::uint8_t>(group.opcode));
      out.put(group.start);
      out.put(group.length);
    });
  }
  // The checksum covers the summary and the footer up to the checksum itself.
  put_record(kFooter, out, [&] {
    out.put(summary_at);
    out.put(offsets_at);
    out.put(std::uint32_t{0});
  });
  out.put_at(out.size() - sizeof(std::uint32_t), crc_of(out.bytes().first(out.size() - sizeof(std::uint32_t))));
}

void McapWriter::put_schema(const ChannelState& state, ByteBuffer& out) const {
  put_record(kSchema, out, [&] {
    out.put(state.schema_id);
    put_string(state.channel.schema_name, out);
    put_string(state.channel.schema_encoding, out);
    put_string(state.channel.schema, out);
  });
}

void McapWriter::put_channel(std::uint16_t id, ByteBuffer& out) const {
  const ChannelState& state = channels_[id - 1U];
  put_record(kChannel, out, [&] {
    out.put(id);
    out.put(state.schema_id);
    put_string(state.channel.topic, out);
    put_string(state.channel.message_encoding, out);
    put_sized<std::uint32_t>(out, [&] {
      for (const auto& [key, value] : state.channel.metadata) {
        put_string(key, out);
        put_string(value, out);
      }
    });
  });
}

void McapWriter::put_chunk_index(const ChunkIndex& index, ByteBuffer& out) const {
  put_record(kChunkIndex, out, [&] {
    out.put(static_cast<std::uint64_t>(index.start));
    out.put(static_cast<std::uint64_t>(index.end));
    out.put(index.offset);
    out.put(index.length);
    put_sized<std::uint32_t>(out, [&] {
      for (const auto& [channel, offset] : index.index_offsets) {
        out.put(channel);
        out.put(offset);
      }
    });
    out.put(index.index_length);
    put_string(options_.compress ? "zstd" : "", out);
    out.put(index.compressed_size);
    out.put(index.uncompressed_size);
  });
}

void McapWriter::put_statistics(ByteBuffer& out) const {
  std::uint64_t num_messages = 0;
  for (const ChannelState& state : channels_) num_messages += state.num_messages;
  TimeNs start = 0, end = 0;
  for (std::size_t i = 0; i < chunks_.size(); ++i) {
    start = i == 0 ? chunks_[i].start : std::min(start, chunks_[i].start);
    end = i == 0 ? chunks_[i].end : std::max(end, chunks_[i].end);
  }
  put_record(kStatistics, out, [&] {
    out.put(num_messages);
    out.put(static_cast<std::uint16_t>(schemas_.size()));
    out.put(static_cast<std::uint32_t>(channels_.size()));
    out.put(std::uint32_t{0});  // attachments
    out.put(std::uint32_t{0});  // metadata
    out.put(static_cast<std::uint32_t>(chunks_.size()));
    out.put(static_cast<std::uint64_t>(start));
    out.put(static_cast<std::uint64_t>(end));
    put_sized<std::uint32_t>(out, [&] {
      for (std::size_t i = 0; i < channels_.size(); ++i) {
        out.put(static_cast<std::uint16_t>(i + 1));
        out.put(channels_[i].num_messages);
      }
    });
  });
}

void McapWriter::append(const ByteBuffer& bytes) {
  crc_ = crc_of(bytes.bytes(), crc_);
  file_.append(bytes.bytes());
}

}  // namespace swiftlet::sim
