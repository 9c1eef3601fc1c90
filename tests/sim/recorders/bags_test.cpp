// SPDX-License-Identifier: BSD-3-Clause
// Bags read by their published formats, record by record: every index leads to its messages.
#include <gtest/gtest.h>

#include <cstring>
#include <map>

#include "sim/recorders/mcap_writer.hpp"
#include "sim/recorders/rosbag_writer.hpp"
#include "swiftlet/sim/io/files.hpp"
#include "tests/support/temporary_directory.hpp"

namespace swiftlet::sim {
namespace {

/// Takes numbers and texts off bytes; reading beyond the end fails the test by an exception.
class Taker {
 public:
  explicit Taker(std::string_view bytes) : bytes_(bytes) {}
  template <class Number>
  Number take() {
    Number value;
    const std::string_view text = take(sizeof value);
    std::memcpy(&value, text.data(), sizeof value);
    return value;
  }
  std::string_view take(std::size_t size) {
    if (size > bytes_.size()) throw std::out_of_range("a length leads beyond the end");
    const std::string_view text = bytes_.substr(0, size);
    bytes_.remove_prefix(size);
    return text;
  }
  std::string_view take_sized() { return take(take<std::uint32_t>()); }
  bool empty() const { return bytes_.empty(); }

 private:
  std::string_view bytes_;
};

/// Message number k: of channel k % 3, at its time, with its text.
constexpr int kMessages = 40;
TimeNs time_of(int k) { return 1'500'000'000 + k * 123'456'789LL; }
std::string text_of_message(int k) { return "message " + std::to_string(k * k); }

/// A record of a ROS 1 bag: fields of the header by name, and its data.
struct BagRecord {
  std::map<std::string, std::string_view, std::less<>> fields;
  std::string_view data;

  explicit BagRecord(Taker& from) {
    for (Taker header(from.take_sized()); !header.empty();) {
      const std::string_view field = header.take_sized();
      const std::size_t equals = field.find('=');
      fields.emplace(field.substr(0, equals), field.substr(equals + 1));
    }
    data = from.take_sized();
  }
  int op() const { return static_cast<unsigned char>(fields.at("op")[0]); }
  template <class Number>
  Number number(const char* name) const {
    EXPECT_EQ(fields.at(name).size(), sizeof(Number)) << name;
    return Taker(fields.at(name)).take<Number>();
  }
  /// Seconds in the lower half, nanoseconds in the upper half.
  static TimeNs time(std::uint64_t words) {
    return static_cast<TimeNs>(words & 0xFFFFFFFF) * 1'000'000'000 + static_cast<TimeNs>(words >> 32);
  }
};

TEST(Rosbag, IndicesAndCountsMatchMessages) {
  const TemporaryDirectory directory;
  const auto file = directory.path() / "a.bag";
  RosbagWriter writer(file, false, 700);
  for (const char* topic : {"/a", "/b", "/c"})
    writer.add_connection({topic, "std_msgs/String", "d41d8", "string data"});
  for (int k = 0; k < kMessages; ++k) {
    const std::string text = text_of_message(k);
    writer.write(static_cast<std::uint32_t>(k % 3), time_of(k), std::as_bytes(std::span(text)));
  }
  writer.finish();

  const std::string bytes = read_whole_file(file);
  Taker all(bytes);
  ASSERT_EQ(all.take(13), "#ROSBAG V2.0\n");
  const BagRecord head(all);
  ASSERT_EQ(head.op(), 3);
  EXPECT_EQ(head.number<std::uint32_t>("conn_count"), 3U);
  std::vector<std::string_view> chunks;
  std::vector<std::map<std::uint32_t, std::uint32_t>> counts;  // per chunk, by connection
  int indexed = 0, connections = 0, infos = 0;
  while (!all.empty()) {
    const BagRecord record(all);
    if (record.op() == 5) {
      EXPECT_EQ(record.number<std::uint32_t>("size"), record.data.size());
      chunks.push_back(record.data);
      counts.emplace_back();
    } else if (record.op() == 4) {
      const auto connection = record.number<std::uint32_t>("conn"), count = record.number<std::uint32_t>("count");
      counts.back()[connection] = count;
      Taker entries(record.data);
      for (std::uint32_t i = 0; i < count; ++i) {
        const TimeNs t = BagRecord::time(entries.take<std::uint64_t>());
        Taker at(chunks.back().substr(entries.take<std::uint32_t>()));
        const BagRecord message(at);
        ASSERT_EQ(message.op(), 2);
        EXPECT_EQ(message.number<std::uint32_t>("conn"), connection);
        EXPECT_EQ(BagRecord::time(message.number<std::uint64_t>("time")), t);
        const int k = static_cast<int>((t - time_of(0)) / (time_of(1) - time_of(0)));
        EXPECT_EQ(t, time_of(k));
        EXPECT_EQ(message.data, text_of_message(k));
        EXPECT_EQ(connection, static_cast<std::uint32_t>(k % 3));
        ++indexed;
      }
      EXPECT_TRUE(entries.empty());
    } else if (record.op() == 7) {
      ++connections;
    } else if (record.op() == 6) {
      const auto offset = record.number<std::uint64_t>("chunk_pos");
      Taker there(std::string_view(bytes).substr(offset));
      EXPECT_EQ(BagRecord(there).data, chunks.at(static_cast<std::size_t>(infos)));
      Taker pairs(record.data);
      std::map<std::uint32_t, std::uint32_t> listed;
      while (!pairs.empty()) {
        const auto connection = pairs.take<std::uint32_t>();
        listed[connection] = pairs.take<std::uint32_t>();
      }
      EXPECT_EQ(listed, counts.at(static_cast<std::size_t>(infos)));
      EXPECT_LE(BagRecord::time(record.number<std::uint64_t>("start_time")),
                BagRecord::time(record.number<std::uint64_t>("end_time")));
      ++infos;
    }
  }
  EXPECT_EQ(indexed, kMessages);
  EXPECT_EQ(connections, 3);
  ASSERT_GT(chunks.size(), 2U);
  EXPECT_EQ(head.number<std::uint32_t>("chunk_count"), chunks.size());
  EXPECT_EQ(static_cast<std::size_t>(infos), chunks.size());
  Taker index(std::string_view(bytes).substr(head.number<std::uint64_t>("index_pos")));
  EXPECT_EQ(BagRecord(index).op(), 7);
}

struct McapRecord {
  int opcode = 0;
  std::string_view content;
  explicit McapRecord(Taker& from)
      : opcode(from.take<std::uint8_t>()), content(from.take(static_cast<std::size_t>(from.take<std::uint64_t>()))) {}
};

TEST(Mcap, SummaryLeadsToChunksAndMessages) {
  const TemporaryDirectory directory;
  const auto file = directory.path() / "a.mcap";
  McapWriter writer(file, {.profile = "", .library = "test", .compress = false, .chunk_bytes = 500});
  for (const char* topic : {"/a", "/b", "/c"}) writer.add_channel({topic, "json", {}, "Text", "jsonschema", "{}"});
  for (int k = 0; k < kMessages; ++k) {
    const std::string text = text_of_message(k);
    writer.write(static_cast<std::uint16_t>(1 + k % 3), static_cast<std::uint32_t>(k), time_of(k),
                 std::as_bytes(std::span(text)));
  }
  writer.finish();

  const std::string bytes = read_whole_file(file);
  const std::string_view whole = bytes;
  ASSERT_EQ(whole.substr(0, 8), whole.substr(whole.size() - 8));
  // The footer is the last record: 1 + 8 bytes, then the places of summary and offsets, and a checksum.
  Taker footer(whole.substr(whole.size() - 8 - 20));
  Taker summary(whole.substr(footer.take<std::uint64_t>()));
  int chunks = 0, found = 0;
  std::uint64_t num_listed = 0;
  for (McapRecord record(summary); record.opcode != 0x02; record = McapRecord(summary)) {
    Taker content(record.content);
    if (record.opcode == 0x0B) num_listed = content.take<std::uint64_t>();
    if (record.opcode != 0x08) continue;
    ++chunks;
    const auto begin = static_cast<TimeNs>(content.take<std::uint64_t>()),
               end = static_cast<TimeNs>(content.take<std::uint64_t>());
    const auto offset = content.take<std::uint64_t>(), length = content.take<std::uint64_t>();
    Taker at_chunk(whole.substr(offset, length));
    const McapRecord chunk(at_chunk);
    ASSERT_EQ(chunk.opcode, 0x06);
    EXPECT_TRUE(at_chunk.empty());
    Taker inside(chunk.content);
    inside.take(8 + 8 + 8 + 4);
    EXPECT_EQ(inside.take_sized(), "");
    const std::string_view records = inside.take(static_cast<std::size_t>(inside.take<std::uint64_t>()));
    for (Taker offsets(content.take_sized()); !offsets.empty();) {
      const auto channel = offsets.take<std::uint16_t>();
      Taker at_index(whole.substr(offsets.take<std::uint64_t>()));
      const McapRecord index(at_index);
      ASSERT_EQ(index.opcode, 0x07);
      Taker entries(index.content);
      ASSERT_EQ(entries.take<std::uint16_t>(), channel);
      for (Taker entry(entries.take_sized()); !entry.empty();) {
        const auto t = static_cast<TimeNs>(entry.take<std::uint64_t>());
        Taker at_message(records.substr(entry.take<std::uint64_t>()));
        const McapRecord message(at_message);
        ASSERT_EQ(message.opcode, 0x05);
        Taker fields(message.content);
        EXPECT_EQ(fields.take<std::uint16_t>(), channel);
        const auto k = static_cast<int>(fields.take<std::uint32_t>());
        EXPECT_EQ(t, time_of(k));
        EXPECT_TRUE(begin <= t && t <= end);
        fields.take(16);
        EXPECT_EQ(fields.take(text_of_message(k).size()), text_of_message(k));
        EXPECT_TRUE(fields.empty());
        ++found;
      }
    }
  }
  EXPECT_EQ(found, kMessages);
  EXPECT_EQ(num_listed, static_cast<std::uint64_t>(kMessages));
  EXPECT_GT(chunks, 2);
}

TEST(Mcap, EmptyFileHasNoChunk) {
  const TemporaryDirectory directory;
  const auto file = directory.path() / "a.mcap";
  McapWriter writer(file, {.profile = "", .library = "test"});
  writer.finish();
  const std::string bytes = read_whole_file(file);
  Taker all(std::string_view(bytes).substr(8, bytes.size() - 16));
  std::vector<int> opcodes;
  while (!all.empty()) {
    const McapRecord record(all);
    opcodes.push_back(record.opcode);
    if (record.opcode != 0x0B) continue;
    EXPECT_EQ(record.content, std::string(record.content.size(), '\0')) << "nothing is counted";
  }
  EXPECT_EQ(opcodes, (std::vector{0x01, 0x0F, 0x0B, 0x0E, 0x02}));
}

}  // namespace
}  // namespace swiftlet::sim
