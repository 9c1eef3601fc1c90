// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "swiftlet/core/base/time.hpp"
#include "swiftlet/sim/io/byte_buffer.hpp"
#include "swiftlet/sim/io/output_file.hpp"

namespace swiftlet::sim {

/// Writes an MCAP file ("MCAP File Format Specification", version 0, mcap.dev): chunks with message indexes, and a
/// summary with schemas, channels, statistics, chunk indexes and offsets. Memory: one chunk, plus a few bytes per
/// chunk.
class McapWriter {
 public:
  struct Options {
    std::string profile;
    std::string library;
    bool compress = true;  ///< with zstd
    int zstd_level = 1;
    std::size_t chunk_bytes = 1 << 20;  ///< least size of a chunk, before compression
  };
  struct Channel {
    std::string topic;
    std::string message_encoding;
    std::map<std::string, std::string> metadata;
    std::string schema_name;
    std::string schema_encoding;
    std::string schema;
  };

  McapWriter(const std::filesystem::path& path, Options options);
  ~McapWriter();
  std::uint16_t add_channel(Channel channel);
  void write(std::uint16_t channel, std::uint32_t sequence, TimeNs t, std::span<const std::byte> message);
  void finish();

 private:
  struct ChannelState {
    Channel channel;
    std::uint16_t schema_id = 0;
    std::uint64_t num_messages = 0;
    ByteBuffer index;  ///< (time, offset) of its messages in the open chunk
  };
  struct ChunkIndex {
    TimeNs start, end;
    std::uint64_t offset, length;
    std::vector<std::pair<std::uint16_t, std::uint64_t>> index_offsets;  ///< channel, offset of its message index
    std::uint64_t index_length;
    std::uint64_t compressed_size, uncompressed_size;
  };

  void close_chunk();
  void append(const ByteBuffer& bytes);
  void put_schema(const ChannelState& state, ByteBuffer& out) const;
  void put_channel(std::uint16_t id, ByteBuffer& out) const;
  void put_chunk_index(const ChunkIndex& index, ByteBuffer& out) const;
  void put_statistics(ByteBuffer& out) const;
  void put_summary(ByteBuffer& out) const;
  std::span<const std::byte> compressed_chunk();

  Options options_;
  OutputFile file_;
  std::uint32_t crc_ = 0;               // checksum of all bytes so far
  std::vector<ChannelState> channels_;  // indexed by id - 1
  std::vector<std::string> schemas_;    // names, indexed by id - 1
  std::vector<ChunkIndex> chunks_;
  ByteBuffer chunk_;
  TimeNs chunk_start_ = 0, chunk_end_ = 0;
  ByteBuffer record_;
  std::vector<std::byte> compressed_;
  struct Compressor;
  std::unique_ptr<Compressor> compressor_;
};

}  // namespace swiftlet::sim
