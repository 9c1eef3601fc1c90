// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstring>
#include <map>
#include <span>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "sim/recorders/ros_topics.hpp"

namespace swiftlet::sim {

/// Content of a ROS message, read only by the definition in its bag. Fields are named like "pose.position.x", elements
/// like "transforms[0].child_frame_id"; times have "sec" and "nanosec" in both dialects.
class RosReading {
 public:
  RosReading(const std::string& definition, std::span<const std::byte> bytes, RosDialect dialect)
      : bytes_(bytes), cdr_(dialect == RosDialect::kRos2) {
    std::istringstream in(definition);
    std::string name, line;
    while (std::getline(in, line)) {
      if (line == std::string(80, '=')) {
        std::getline(in, line);
        if (!line.starts_with("MSG: ")) throw std::runtime_error("expected the name of a type, found " + line);
        name = line.substr(5);
      } else if (!line.empty() && line.find('=') == std::string::npos) {
        const std::size_t blank = line.find(' ');
        types_[name].emplace_back(line.substr(0, blank), line.substr(blank + 1));
      }
    }
    if (cdr_) {
      const std::byte head[] = {std::byte{0}, std::byte{1}, std::byte{0}, std::byte{0}};
      if (bytes.size() < 4 || std::memcmp(bytes.data(), head, 4) != 0) throw std::runtime_error("no little-endian CDR");
      at_ = 4;
    }
    read_type("", "");
    if (at_ != bytes_.size()) throw std::runtime_error("the message is longer than its fields");
  }

  double number(const std::string& path) const { return get(numbers_, path); }
  const std::string& text(const std::string& path) const { return get(texts_, path); }
  std::size_t count(const std::string& path) const { return static_cast<std::size_t>(number(path + ".size")); }
  bool has(const std::string& path) const { return numbers_.contains(path) || texts_.contains(path); }
  TimeNs time(const std::string& path) const {
    return static_cast<TimeNs>(number(path + ".sec")) * 1'000'000'000 + static_cast<TimeNs>(number(path + ".nanosec"));
  }
  Vector3 vector(const std::string& path) const {
    return {number(path + ".x"), number(path + ".y"), number(path + ".z")};
  }
  Eigen::Quaterniond rotation(const std::string& path) const {
    return {number(path + ".w"), number(path + ".x"), number(path + ".y"), number(path + ".z")};
  }
  /// An array of fixed length.
  std::vector<double> array(const std::string& path) const {
    std::vector<double> values;
    for (std::size_t i = 0; has(path + "[" + std::to_string(i) + "]"); ++i) {
      values.push_back(number(path + "[" + std::to_string(i) + "]"));
    }
    return values;
  }

 private:
  template <class Map>
  static const typename Map::mapped_type& get(const Map& map, const std::string& path) {
    const auto found = map.find(path);
    if (found == map.end()) throw std::runtime_error("the message has no " + path);
    return found->second;
  }

  std::span<const std::byte> take(std::size_t size) {
    if (size > bytes_.size() - at_) throw std::runtime_error("the message ends within a field");
    at_ += size;
    return bytes_.subspan(at_ - size, size);
  }
  template <class Number>
  Number take() {
    while (cdr_ && (at_ - 4) % sizeof(Number) != 0) take(1);
    Number value{};
    std::memcpy(&value, take(sizeof value).data(), sizeof value);
    return value;
  }

  void read_type(const std::string& type, const std::string& path) {
    if (!types_.contains(type)) throw std::runtime_error("no definition of " + type);
    for (const auto& [field, name] : types_[type]) {
      const std::string below = path.empty() ? name : path + "." + name;
      const std::size_t bracket = field.find('[');
      if (bracket == std::string::npos) {
        read_value(field, below);
        continue;
      }
      const std::string element = field.substr(0, bracket),
                        length = field.substr(bracket + 1, field.size() - bracket - 2);
      const std::size_t count = length.empty() ? take<std::uint32_t>() : std::stoul(length);
      numbers_[below + ".size"] = static_cast<double>(count);
      if (element == "uint8" && length.empty()) {
        const auto blob = take(count);
        texts_[below].assign(reinterpret_cast<const char*>(blob.data()), blob.size());
        continue;
      }
      for (std::size_t i = 0; i < count; ++i) read_value(element, below + "[" + std::to_string(i) + "]");
    }
  }

  void read_value(const std::string& type, const std::string& path) {
    if (type == "string") {
      std::size_t size = take<std::uint32_t>();
      const auto text = take(size);
      if (cdr_ && (size == 0 || text[--size] != std::byte{0}))
        throw std::runtime_error(path + " does not end with zero");
      texts_[path].assign(reinterpret_cast<const char*>(text.data()), size);
    } else if (type == "time" || type == "duration") {
      numbers_[path + ".sec"] = take<std::int32_t>();
      numbers_[path + ".nanosec"] = take<std::uint32_t>();
    } else if (type == "bool" || type == "uint8") {
      numbers_[path] = take<std::uint8_t>();
    } else if (type == "int8") {
      numbers_[path] = take<std::int8_t>();
    } else if (type == "uint16") {
      numbers_[path] = take<std::uint16_t>();
    } else if (type == "int32") {
      numbers_[path] = take<std::int32_t>();
    } else if (type == "uint32") {
      numbers_[path] = take<std::uint32_t>();
    } else if (type == "int64") {
      numbers_[path] = static_cast<double>(take<std::int64_t>());
    } else if (type == "float32") {
      numbers_[path] = static_cast<double>(take<float>());
    } else if (type == "float64") {
      numbers_[path] = take<double>();
    } else {
      read_type(type, path);
    }
  }

  std::span<const std::byte> bytes_;
  bool cdr_;
  std::size_t at_ = 0;
  std::map<std::string, std::vector<std::pair<std::string, std::string>>> types_;  // fields: type, name
  std::map<std::string, double> numbers_;
  std::map<std::string, std::string> texts_;
};

/// Keeps every message of RosTopics.
class KeepingSink : public RosSink {
 public:
  struct Channel {
    std::string topic;
    RosType type;
    bool latched;
  };
  struct Sent {
    int channel;
    std::uint32_t sequence;
    TimeNs t;
    std::vector<std::byte> bytes;
  };

  explicit KeepingSink(RosDialect dialect) : dialect_(dialect) {}

  int add_channel(const std::string& topic, const RosType& type, bool latched) override {
    channels.push_back({topic, type, latched});
    return static_cast<int>(channels.size()) - 1;
  }
  void write(int channel, std::uint32_t sequence, TimeNs t, std::span<const std::byte> message) override {
    sent.push_back({channel, sequence, t, {message.begin(), message.end()}});
  }

  const std::string& topic_of(const Sent& message) const {
    return channels.at(static_cast<std::size_t>(message.channel)).topic;
  }
  RosReading read(const Sent& message) const {
    const Channel& channel = channels.at(static_cast<std::size_t>(message.channel));
    return {full_definition(channel.type, dialect_), message.bytes, dialect_};
  }
  /// Messages of one topic in order.
  std::vector<RosReading> read_all(const std::string& topic) const {
    std::vector<RosReading> readings;
    for (const Sent& message : sent) {
      if (topic_of(message) == topic) readings.push_back(read(message));
    }
    return readings;
  }

  std::vector<Channel> channels;
  std::vector<Sent> sent;

 private:
  RosDialect dialect_;
};

}  // namespace swiftlet::sim
