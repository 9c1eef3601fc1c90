// SPDX-License-Identifier: BSD-3-Clause
#include "sim/recorders/rosbag_writer.hpp"

#include <lz4frame.h>

#include <algorithm>
#include <stdexcept>

namespace swiftlet::sim {
namespace {

/// Record types of the bag format.
enum Op : std::uint8_t { kBagMessage = 2, kBagHeader = 3, kIndex = 4, kBagChunk = 5, kChunkInfo = 6, kConnection = 7 };

constexpr std::string_view kVersionLine = "#ROSBAG V2.0\n";
/// [bytes] Size of the bag header record. The padding lets finish() overwrite it with the final counts.
constexpr std::size_t kBagHeaderBytes = 4096;

/// Appends the bytes that `content` writes, preceded by their number (32 bits).
template <class Content>
void put_field(ByteBuffer& out, Content content) {
  const std::size_t start = out.size();
  out.put(std::uint32_t{0});
  content();
  out.put_at(start, static_cast<std::uint32_t>(out.size() - start - sizeof(std::uint32_t)));
}

/// Appends a record: header with the record type and the given fields, then data.
template <class Fields, class Data>
void put_record(ByteBuffer& out, Op op, Fields fields, Data data) {
  put_field(out, [&] {
    put_field(out, [&] {
      out.put_text("op=");
      out.put(static_cast<std::uint8_t>(op));
    });
    fields();
  });
  put_field(out, data);
}

template <class Number>
void put_number(ByteBuffer& out, std::string_view name, Number value) {
  put_field(out, [&] {
    out.put_text(name);
    out.put_text("=");
    out.put(value);
  });
}

void put_text(ByteBuffer& out, std::string_view name, std::string_view text) {
  put_field(out, [&] {
    out.put_text(name);
    out.put_text("=");
    out.put_text(text);
  });
}

/// ROS time in one word: seconds in the lower 32 bits, nanoseconds within the second in the upper ones.
std::uint64_t ros_time(TimeNs t) {
  const auto nanoseconds = static_cast<std::uint64_t>(t % kNsPerSecond);
  return nanoseconds << 32 | static_cast<std::uint64_t>(t / kNsPerSecond);
}

}  // namespace

RosbagWriter::RosbagWriter(const std::filesystem::path& path, bool compress, std::size_t chunk_bytes)
    : file_(path), compress_(compress), chunk_bytes_(chunk_bytes) {
  file_.append(kVersionLine);
  put_bag_header(0, record_);
  file_.append(record_.bytes());
}

std::uint32_t RosbagWriter::add_connection(Connection connection) {
  const auto id = static_cast<std::uint32_t>(connections_.size());
  connections_.push_back({std::move(connection), {}, 0});
  put_connection(id, chunk_);
  return id;
}

void RosbagWriter::write(std::uint32_t connection, TimeNs t, std::span<const std::byte> message) {
  t = std::max<TimeNs>(t, 1);  // ros::TIME_MIN; readers interpret 0 as no time
  ConnectionState& state = connections_.at(connection);
  const bool first =
      std::all_of(connections_.begin(), connections_.end(), [](const auto& c) { return c.index.empty(); });
  chunk_start_ = first ? t : std::min(chunk_start_, t);
  chunk_end_ = first ? t : std::max(chunk_end_, t);
  state.index.put(ros_time(t));
  state.index.put(static_cast<std::uint32_t>(chunk_.size()));
  ++state.num_in_chunk;
  put_record(
      chunk_, kBagMessage,
      [&] {
        put_number(chunk_, "conn", connection);
        put_number(chunk_, "time", ros_time(t));
      },
      [&] { chunk_.put_bytes(message); });
  if (chunk_.size() >= chunk_bytes_) close_chunk();
}

void RosbagWriter::close_chunk() {
  if (chunk_.empty()) return;
  ChunkInfo info{file_.size(), chunk_start_, chunk_end_, {}};
  const std::span<const std::byte> data = compressed_chunk();
  record_.clear();
  put_record(
      record_, kBagChunk,
      [&] {
        put_text(record_, "compression", compress_ ? "lz4" : "none");
        put_number(record_, "size", static_cast<std::uint32_t>(chunk_.size()));
      },
      [&] { record_.put_bytes(data); });
  // An index record per connection with messages in the chunk follows the chunk.
  for (std::uint32_t id = 0; id < connections_.size(); ++id) {
    ConnectionState& state = connections_[id];
    if (state.index.empty()) continue;
    info.counts.emplace_back(id, state.num_in_chunk);
    put_record(
        record_, kIndex,
        [&] {
          put_number(record_, "ver", std::uint32_t{1});
          put_number(record_, "conn", id);
          put_number(record_, "count", state.num_in_chunk);
        },
        [&] { record_.put_bytes(state.index.bytes()); });
    state.index.clear();
    state.num_in_chunk = 0;
  }
  file_.append(record_.bytes());
  chunks_.push_back(std::move(info));
  chunk_.clear();
}

std::span<const std::byte> RosbagWriter::compressed_chunk() {
  if (!compress_) return chunk_.bytes();
  // ROS's own LZ4 stream reader supports only independent blocks, a checksum of the content, and no other frame fields.
  LZ4F_preferences_t preferences{};
  preferences.frameInfo.blockSizeID = LZ4F_max4MB;
  preferences.frameInfo.blockMode = LZ4F_blockIndependent;
  preferences.frameInfo.contentChecksumFlag = LZ4F_contentChecksumEnabled;
  compressed_.resize(LZ4F_compressFrameBound(chunk_.size(), &preferences));
  const std::size_t size =
      LZ4F_compressFrame(compressed_.data(), compressed_.size(), chunk_.bytes().data(), chunk_.size(), &preferences);
  if (LZ4F_isError(size)) {
    throw std::runtime_error("cannot write " + file_.path().string() + ": lz4: " + LZ4F_getErrorName(size));
  }
  return std::span(compressed_).first(size);
}

void RosbagWriter::finish() {
  close_chunk();
  const std::uint64_t index_at = file_.size();
  record_.clear();
  for (std::uint32_t id = 0; id < connections_.size(); ++id) put_connection(id, record_);
  for (const ChunkInfo& info : chunks_) {
    put_record(
        record_, kChunkInfo,
        [&] {
          put_number(record_, "ver", std::uint32_t{1});
          put_number(record_, "chunk_pos", info.offset);
          put_number(record_, "start_time", ros_time(info.start));
          put_number(record_, "end_time", ros_time(info.end));
          put_number(record_, "count", static_cast<std::uint32_t>(info.counts.size()));
        },
        [&] {
          for (const auto& [connection, count] : info.counts) {
            record_.put(connection);
            record_.put(count);
          }
        });
  }
  file_.append(record_.bytes());
  record_.clear();
  put_bag_header(index_at, record_);
  file_.overwrite(kVersionLine.size(), record_.bytes());
  file_.finish();
}

void RosbagWriter::put_bag_header(std::uint64_t index_at, ByteBuffer& out) const {
  const std::size_t start = out.size();
  put_record(
      out, kBagHeader,
      [&] {
        put_number(out, "index_pos", index_at);
        put_number(out, "conn_count", static_cast<std::uint32_t>(connections_.size()));
        put_number(out, "chunk_count", static_cast<std::uint32_t>(chunks_.size()));
      },
      [&] { out.put_text(std::string(kBagHeaderBytes - (out.size() - start), ' ')); });
}

void RosbagWriter::put_connection(std::uint32_t id, ByteBuffer& out) const {
  const Connection& connection = connections_[id].connection;
  put_record(
      out, kConnection,
      [&] {
        put_number(out, "conn", id);
        put_text(out, "topic", connection.topic);
      },
      [&] {
        put_text(out, "topic", connection.topic);
        put_text(out, "type", connection.type);
        put_text(out, "md5sum", connection.md5);
        put_text(out, "message_definition", connection.definition);
        put_text(out, "callerid", "/swiftlet");
        put_text(out, "latching", connection.latched ? "1" : "0");
      });
}

}  // namespace swiftlet::sim
