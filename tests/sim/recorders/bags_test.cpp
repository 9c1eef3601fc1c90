// SPDX-License-Identifier: BSD-3-Clause
// Bags read by their published formats, record by record: every index leads to the messages that it tells of.
#include <gtest/gtest.h>
#include <lz4frame.h>
#include <zlib.h>
#include <zstd.h>

#include <algorithm>
#include <cstring>
#include <fstream>
#include <limits>
#include <map>
#include <optional>
#include <sstream>

#include "sim/recorders/mcap_writer.hpp"
#include "sim/recorders/rosbag_writer.hpp"
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

std::string bytes_of_file(const std::filesystem::path& file) {
  std::ostringstream text;
  text << std::ifstream(file, std::ios::binary).rdbuf();
  return text.str();
}

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
  /// Seconds in the first word, nanoseconds in the second.
  static TimeNs time(std::uint64_t words) {
    return static_cast<TimeNs>(words & 0xFFFFFFFF) * 1'000'000'000 + static_cast<TimeNs>(words >> 32);
  }
};

TEST(Rosbag, EveryIndexLeadsToItsMessagesAndEveryCountIsRight) {
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

  const std::string bytes = bytes_of_file(file);
  Taker all(bytes);
  ASSERT_EQ(all.take(13), "#ROSBAG V2.0\n");
  const BagRecord head(all);
  ASSERT_EQ(head.op(), 3);
  EXPECT_EQ(head.number<std::uint32_t>("conn_count"), 3U);
  std::vector<std::string_view> chunks;
  std::vector<std::map<std::uint32_t, std::uint32_t>> counts;  // of each chunk, by connection
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
      std::map<std::uint32_t, std::uint32_t> told;
      while (!pairs.empty()) {
        const auto connection = pairs.take<std::uint32_t>();
        told[connection] = pairs.take<std::uint32_t>();
      }
      EXPECT_EQ(told, counts.at(static_cast<std::size_t>(infos)));
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

/// Times that go to and fro, and some that ROS 1 does not have.
TimeNs time_to_and_fro(int k) {
  return k == 11 ? 0 : k == 12 ? -5 : 1'400'000'000 + k * 37 % kMessages * 250'000'000LL;
}

/// The data of a chunk as they were before compression.
std::string unpacked_by_lz4(std::string_view packed, std::size_t size) {
  // LZ4 frames: magic number, then flags: version 1, blocks that stand alone, a checksum of the content.
  EXPECT_EQ(packed.substr(0, 4), "\x04\x22\x4D\x18");
  EXPECT_EQ(static_cast<unsigned char>(packed[4]), 0x40 | 0x20 | 0x04);
  LZ4F_dctx* context = nullptr;
  LZ4F_createDecompressionContext(&context, LZ4F_VERSION);
  std::string text(size + 1, '\0');
  std::size_t written = text.size(), read = packed.size();
  EXPECT_EQ(LZ4F_decompress(context, text.data(), &written, packed.data(), &read, nullptr), 0U) << "the frame is whole";
  EXPECT_EQ(read, packed.size());
  EXPECT_EQ(written, size);
  LZ4F_freeDecompressionContext(context);
  return text.substr(0, size);
}

TEST(Rosbag, ChunksTellTheirTimesAndConnectionsWhatTheyCarry) {
  for (const bool compress : {false, true}) {
    const TemporaryDirectory directory;
    const auto file = directory.path() / "a.bag";
    RosbagWriter writer(file, compress, 700);
    EXPECT_EQ(writer.add_connection({"/a", "std_msgs/String", "d41d8", "string data"}), 0U);
    EXPECT_EQ(writer.add_connection({"/b", "std_msgs/Empty", "beef", "", true}), 1U);
    std::size_t in_chunk = 0;
    for (int k = 0; k < kMessages; ++k) {
      const std::string text = text_of_message(k);
      writer.write(static_cast<std::uint32_t>(k % 2), time_to_and_fro(k), std::as_bytes(std::span(text)));
    }
    writer.finish();

    const std::string bytes = bytes_of_file(file);
    Taker all(bytes);
    all.take(13);
    const BagRecord head(all);
    // Readers expect this much, and may write over it.
    Taker behind_head(std::string_view(bytes).substr(13 + 4096));
    EXPECT_EQ(BagRecord(behind_head).op(), 5);
    EXPECT_EQ(head.number<std::uint32_t>("conn_count"), 2U);

    struct Span {
      TimeNs start, end;
    };
    std::vector<Span> spans;
    std::vector<TimeNs> times;
    const auto expect_connection = [](const BagRecord& record) {
      const auto id = record.number<std::uint32_t>("conn");
      EXPECT_EQ(record.fields.at("topic"), id == 0 ? "/a" : "/b");
      std::map<std::string, std::string_view, std::less<>> data;
      for (Taker fields(record.data); !fields.empty();) {
        const std::string_view field = fields.take_sized();
        data.emplace(field.substr(0, field.find('=')), field.substr(field.find('=') + 1));
      }
      EXPECT_EQ(data.at("topic"), id == 0 ? "/a" : "/b");
      EXPECT_EQ(data.at("type"), id == 0 ? "std_msgs/String" : "std_msgs/Empty");
      EXPECT_EQ(data.at("md5sum"), id == 0 ? "d41d8" : "beef");
      EXPECT_EQ(data.at("message_definition"), id == 0 ? "string data" : "");
      EXPECT_EQ(data.at("latching"), id == 0 ? "0" : "1");
    };
    std::size_t infos = 0, connections = 0, index_records = 0;
    while (!all.empty()) {
      const BagRecord record(all);
      if (record.op() == 5) {
        EXPECT_EQ(record.fields.at("compression"), compress ? "lz4" : "none");
        const auto size = record.number<std::uint32_t>("size");
        const std::string data = compress ? unpacked_by_lz4(record.data, size) : std::string(record.data);
        ASSERT_EQ(data.size(), size);
        if (spans.empty()) in_chunk = size;
        Span span{std::numeric_limits<TimeNs>::max(), 0};
        std::size_t of_last = 0;
        for (Taker inside(data); !inside.empty();) {
          const BagRecord part(inside);
          of_last = part.data.size() + 8;
          for (const auto& [name, value] : part.fields) of_last += 4 + name.size() + 1 + value.size();
          if (part.op() == 7) {
            expect_connection(part);
            continue;
          }
          const TimeNs t = BagRecord::time(part.number<std::uint64_t>("time"));
          EXPECT_EQ(part.data, text_of_message(static_cast<int>(times.size())));
          EXPECT_EQ(part.number<std::uint32_t>("conn"), times.size() % 2);
          times.push_back(t);
          span = {std::min(span.start, t), std::max(span.end, t)};
        }
        EXPECT_LT(size - of_last, 700U) << "a chunk that has enough is closed";
        spans.push_back(span);
      } else if (record.op() == 4) {
        EXPECT_EQ(record.number<std::uint32_t>("ver"), 1U);
        ++index_records;
      } else if (record.op() == 7) {
        expect_connection(record);
        ++connections;
      } else if (record.op() == 6) {
        EXPECT_EQ(record.number<std::uint32_t>("ver"), 1U);
        EXPECT_EQ(record.number<std::uint32_t>("count"), 2U);
        EXPECT_EQ(BagRecord::time(record.number<std::uint64_t>("start_time")), spans.at(infos).start);
        EXPECT_EQ(BagRecord::time(record.number<std::uint64_t>("end_time")), spans.at(infos).end);
        ++infos;
      }
    }
    ASSERT_EQ(times.size(), static_cast<std::size_t>(kMessages));
    for (int k = 0; k < kMessages; ++k)
      EXPECT_EQ(times[static_cast<std::size_t>(k)], std::max<TimeNs>(time_to_and_fro(k), 1)) << "1 ns is the least";
    EXPECT_GE(in_chunk, 700U);
    EXPECT_GT(spans.size(), 2U);
    EXPECT_EQ(index_records, 2 * spans.size());
    EXPECT_EQ(infos, spans.size());
    EXPECT_EQ(connections, 2U);
  }
}

struct McapRecord {
  int opcode = 0;
  std::string_view content;
  explicit McapRecord(Taker& from)
      : opcode(from.take<std::uint8_t>()), content(from.take(static_cast<std::size_t>(from.take<std::uint64_t>()))) {}
};

TEST(Mcap, TheSummaryLeadsToEveryChunkAndEveryMessage) {
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

  const std::string bytes = bytes_of_file(file);
  const std::string_view whole = bytes;
  ASSERT_EQ(whole.substr(0, 8), whole.substr(whole.size() - 8));
  // The footer is the last record: 1 + 8 bytes, then the places of summary and offsets, and a checksum.
  Taker footer(whole.substr(whole.size() - 8 - 20));
  Taker summary(whole.substr(footer.take<std::uint64_t>()));
  int chunks = 0, found = 0;
  std::uint64_t told = 0;
  for (McapRecord record(summary); record.opcode != 0x02; record = McapRecord(summary)) {
    Taker content(record.content);
    if (record.opcode == 0x0B) told = content.take<std::uint64_t>();
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
  EXPECT_EQ(told, static_cast<std::uint64_t>(kMessages));
  EXPECT_GT(chunks, 2);
}

std::uint32_t crc_of(std::string_view bytes) {
  return static_cast<std::uint32_t>(
      crc32(0, reinterpret_cast<const Bytef*>(bytes.data()), static_cast<uInt>(bytes.size())));
}
std::string text_of(Taker& from) { return std::string(from.take_sized()); }

/// A schema or channel with what it tells, as one text.
std::string told_by_schema(std::string_view content) {
  Taker from(content);
  std::string text = std::to_string(from.take<std::uint16_t>());
  for (int i = 0; i < 3; ++i) text += "|" + text_of(from);
  EXPECT_TRUE(from.empty());
  return text;
}
std::string told_by_channel(std::string_view content) {
  Taker from(content);
  std::string text = std::to_string(from.take<std::uint16_t>());
  text += "|" + std::to_string(from.take<std::uint16_t>());
  text += "|" + text_of(from);
  text += "|" + text_of(from);
  for (Taker map(from.take_sized()); !map.empty();) {
    text += "|" + text_of(map);
    text += "=" + text_of(map);
  }
  EXPECT_TRUE(from.empty());
  return text;
}

/// The whole file from front to back, by the specification of MCAP.
TEST(Mcap, EveryRecordIsWhereItBelongsWithTheRightCountsAndChecksums) {
  for (const bool compress : {false, true}) {
    const TemporaryDirectory directory;
    const auto file = directory.path() / "a.mcap";
    McapWriter writer(file, {.profile = "ros2", .library = "test", .compress = compress, .chunk_bytes = 500});
    EXPECT_EQ(writer.add_channel({"/a", "json", {{"key", "value"}, {"more", ""}}, "Text", "jsonschema", "{}"}), 1);
    EXPECT_EQ(writer.add_channel({"/b", "cdr", {}, "Number", "ros2msg", "int32 n"}), 2);
    EXPECT_EQ(writer.add_channel({"/c", "json", {}, "Text", "jsonschema", "{}"}), 3);
    for (int k = 0; k < kMessages; ++k) {
      const std::string text = text_of_message(k);
      writer.write(static_cast<std::uint16_t>(1 + k % 3), static_cast<std::uint32_t>(k), time_to_and_fro(k),
                   std::as_bytes(std::span(text)));
    }
    writer.finish();

    const std::vector<std::string> schemas = {"1|Text|jsonschema|{}", "2|Number|ros2msg|int32 n"};
    const std::vector<std::string> channels = {"1|1|/a|json|key=value|more=", "2|2|/b|cdr", "3|1|/c|json"};
    const std::string bytes = bytes_of_file(file);
    const std::string_view whole = bytes;
    const std::string magic = "\x89MCAP0\r\n";
    ASSERT_EQ(whole.substr(0, 8), magic);
    ASSERT_EQ(whole.substr(whole.size() - 8), magic);

    struct Chunk {
      std::uint64_t start, end, offset, length;
      std::map<std::uint16_t, std::uint64_t> index_offsets;
      std::uint64_t index_length, compressed, uncompressed;
      bool operator==(const Chunk&) const = default;
    };
    std::vector<Chunk> chunks, told_chunks;
    std::vector<std::string> schemas_inside, channels_inside, schemas_told, channels_told;
    std::vector<std::pair<int, std::pair<std::uint64_t, std::uint64_t>>> groups, groups_told;  // opcode, place, length
    int k = 0;
    bool in_summary = false;
    std::uint64_t summary_at = 0, offsets_at = 0;
    Taker all(whole.substr(8));
    std::size_t at = 8;
    for (bool ended = false; !ended;) {
      const std::size_t record_at = at;
      const McapRecord record(all);
      at += 9 + record.content.size();
      Taker content(record.content);
      if (in_summary && record.opcode != 0x02 && record.opcode != 0x0E) {
        if (summary_at == 0) summary_at = record_at;
        if (groups.empty() || groups.back().first != record.opcode) groups.push_back({record.opcode, {record_at, 0}});
        groups.back().second.second += at - record_at;
      }
      switch (record.opcode) {
        case 0x01:
          EXPECT_EQ(record_at, 8U);
          EXPECT_EQ(content.take_sized(), "ros2");
          EXPECT_EQ(content.take_sized(), "test");
          break;
        case 0x06: {
          Chunk& chunk = chunks.emplace_back();
          chunk.offset = record_at;
          chunk.length = at - record_at;
          chunk.start = content.take<std::uint64_t>();
          chunk.end = content.take<std::uint64_t>();
          chunk.uncompressed = content.take<std::uint64_t>();
          const auto crc = content.take<std::uint32_t>();
          EXPECT_EQ(content.take_sized(), compress ? "zstd" : "");
          chunk.compressed = content.take<std::uint64_t>();
          const std::string_view packed = content.take(static_cast<std::size_t>(chunk.compressed));
          std::string records(packed);
          if (compress) {
            records.resize(static_cast<std::size_t>(chunk.uncompressed));
            EXPECT_EQ(ZSTD_decompress(records.data(), records.size(), packed.data(), packed.size()), records.size());
          }
          EXPECT_EQ(records.size(), chunk.uncompressed);
          EXPECT_EQ(crc, crc_of(records));
          std::vector<TimeNs> times;
          std::size_t before_last = 0;
          for (Taker inside(records); !inside.empty();) {
            const McapRecord part(inside);
            if (part.opcode == 0x03) schemas_inside.push_back(told_by_schema(part.content));
            if (part.opcode == 0x04) channels_inside.push_back(told_by_channel(part.content));
            if (part.opcode != 0x05) continue;
            before_last = static_cast<std::size_t>(part.content.data() - 9 - records.data());
            Taker fields(part.content);
            EXPECT_EQ(fields.take<std::uint16_t>(), 1 + k % 3);
            EXPECT_EQ(fields.take<std::uint32_t>(), static_cast<std::uint32_t>(k));
            const auto log = fields.take<std::uint64_t>();
            EXPECT_EQ(log, static_cast<std::uint64_t>(time_to_and_fro(k)));
            EXPECT_EQ(fields.take<std::uint64_t>(), log) << "published when it was logged";
            EXPECT_EQ(fields.take(text_of_message(k).size()), text_of_message(k));
            EXPECT_TRUE(fields.empty());
            times.push_back(static_cast<TimeNs>(log));
            ++k;
          }
          EXPECT_LT(before_last, 500U) << "a chunk that has enough is closed";
          EXPECT_TRUE(chunk.uncompressed >= 500 || k == kMessages);
          const auto [first, last] = std::minmax_element(times.begin(), times.end());
          EXPECT_EQ(static_cast<TimeNs>(chunk.start), *first) << "before zero is before";
          EXPECT_EQ(static_cast<TimeNs>(chunk.end), *last);
          break;
        }
        case 0x07: {
          Chunk& chunk = chunks.back();
          chunk.index_length += at - record_at;
          chunk.index_offsets[content.take<std::uint16_t>()] = record_at;
          break;
        }
        case 0x0F:
          EXPECT_EQ(content.take<std::uint32_t>(), crc_of(whole.substr(0, record_at)));
          in_summary = true;
          break;
        case 0x03:
          schemas_told.push_back(told_by_schema(record.content));
          break;
        case 0x04:
          channels_told.push_back(told_by_channel(record.content));
          break;
        case 0x0B: {
          EXPECT_EQ(content.take<std::uint64_t>(), static_cast<std::uint64_t>(kMessages));
          EXPECT_EQ(content.take<std::uint16_t>(), 2U) << "schemas";
          EXPECT_EQ(content.take<std::uint32_t>(), 3U) << "channels";
          EXPECT_EQ(content.take<std::uint32_t>(), 0U) << "attachments";
          EXPECT_EQ(content.take<std::uint32_t>(), 0U) << "metadata";
          EXPECT_EQ(content.take<std::uint32_t>(), chunks.size());
          EXPECT_EQ(static_cast<TimeNs>(content.take<std::uint64_t>()), -5);
          EXPECT_EQ(static_cast<TimeNs>(content.take<std::uint64_t>()),
                    1'400'000'000 + (kMessages - 1) * 250'000'000LL);
          std::map<std::uint16_t, std::uint64_t> counts;
          for (Taker pairs(content.take_sized()); !pairs.empty();) {
            const auto id = pairs.take<std::uint16_t>();
            counts[id] = pairs.take<std::uint64_t>();
          }
          EXPECT_EQ(counts, (std::map<std::uint16_t, std::uint64_t>{{1, 14}, {2, 13}, {3, 13}}));
          break;
        }
        case 0x08: {
          Chunk& chunk = told_chunks.emplace_back();
          chunk.start = content.take<std::uint64_t>();
          chunk.end = content.take<std::uint64_t>();
          chunk.offset = content.take<std::uint64_t>();
          chunk.length = content.take<std::uint64_t>();
          for (Taker pairs(content.take_sized()); !pairs.empty();) {
            const auto id = pairs.take<std::uint16_t>();
            chunk.index_offsets[id] = pairs.take<std::uint64_t>();
          }
          chunk.index_length = content.take<std::uint64_t>();
          EXPECT_EQ(content.take_sized(), compress ? "zstd" : "");
          chunk.compressed = content.take<std::uint64_t>();
          chunk.uncompressed = content.take<std::uint64_t>();
          break;
        }
        case 0x0E: {
          if (offsets_at == 0) offsets_at = record_at;
          const int opcode = content.take<std::uint8_t>();
          const auto start = content.take<std::uint64_t>(), length = content.take<std::uint64_t>();
          groups_told.push_back({opcode, {start, length}});
          break;
        }
        case 0x02: {
          EXPECT_EQ(content.take<std::uint64_t>(), summary_at);
          EXPECT_EQ(content.take<std::uint64_t>(), offsets_at);
          const std::size_t crc_at = at - 4;
          EXPECT_EQ(content.take<std::uint32_t>(), crc_of(whole.substr(static_cast<std::size_t>(summary_at),
                                                                       crc_at - static_cast<std::size_t>(summary_at))));
          ended = true;
          break;
        }
        default:
          FAIL() << "a record that nobody wrote: " << record.opcode;
      }
    }
    EXPECT_EQ(at, whole.size() - 8);
    EXPECT_EQ(k, kMessages);
    EXPECT_EQ(schemas_inside, schemas);
    EXPECT_EQ(channels_inside, channels);
    EXPECT_EQ(schemas_told, schemas);
    EXPECT_EQ(channels_told, channels);
    EXPECT_GT(chunks.size(), 2U);
    EXPECT_EQ(told_chunks, chunks);
    EXPECT_EQ(groups_told, groups);
    EXPECT_EQ(groups.size(), 4U);
  }
}

TEST(Mcap, AFileWithoutMessagesHasNoTimeAndNoChunk) {
  const TemporaryDirectory directory;
  const auto file = directory.path() / "a.mcap";
  McapWriter writer(file, {.profile = "", .library = "test"});
  writer.finish();
  const std::string bytes = bytes_of_file(file);
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
