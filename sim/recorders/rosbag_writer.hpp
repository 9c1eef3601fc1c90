// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "swiftlet/core/base/time.hpp"
#include "swiftlet/sim/io/byte_buffer.hpp"
#include "swiftlet/sim/io/output_file.hpp"

namespace swiftlet::sim {

/// Writes a ROS 1 bag (wiki.ros.org/Bags/Format/2.0): chunks with their indexes, then connections and chunk infos.
/// Memory: one chunk, plus a few bytes per chunk.
class RosbagWriter {
 public:
  struct Connection {
    std::string topic;
    std::string type;
    std::string md5;
    std::string definition;
    bool latched = false;
  };

  /// @param compress  compress chunks with LZ4
  RosbagWriter(const std::filesystem::path& path, bool compress, std::size_t chunk_bytes = 768 * 1024);
  std::uint32_t add_connection(Connection connection);
  void write(std::uint32_t connection, TimeNs t, std::span<const std::byte> message);
  void finish();

 private:
  struct ConnectionState {
    Connection connection;
    ByteBuffer index;  ///< (time, offset) of its messages in the open chunk
    std::uint32_t num_in_chunk = 0;
  };
  struct ChunkInfo {
    std::uint64_t offset;
    TimeNs start, end;
    std::vector<std::pair<std::uint32_t, std::uint32_t>> counts;  ///< connection, messages
  };

  void close_chunk();
  void put_bag_header(std::uint64_t index_at, ByteBuffer& out) const;
  void put_connection(std::uint32_t id, ByteBuffer& out) const;
  std::span<const std::byte> compressed_chunk();

  OutputFile file_;
  bool compress_;
  std::size_t chunk_bytes_;
  std::vector<ConnectionState> connections_;  // indexed by id
  std::vector<ChunkInfo> chunks_;
  ByteBuffer chunk_;
  TimeNs chunk_start_ = 0, chunk_end_ = 0;
  ByteBuffer record_;
  std::vector<std::byte> compressed_;
};

}  // namespace swiftlet::sim
