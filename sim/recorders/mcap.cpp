// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/recorders/mcap.hpp"

#include "sim/recorders/ros_topics.hpp"

#include <nlohmann/json.hpp>
#include <optional>

#include "sim/recorders/mcap_writer.hpp"
#include "swiftlet/sim/io/files.hpp"

namespace swiftlet::sim {
namespace {

/// Quality of service of a publisher in rosbag2's format: numbers of rmw_qos_*_policy_t. A latched topic is transient
/// local, so that late subscribers of a replay get its last message.
std::string offered_qos_profiles(bool latched) {
  const std::string infinite = "\n    sec: 9223372036\n    nsec: 854775807\n";
  return "- history: 1\n  depth: " + std::string(latched ? "1" : "10") +
         "\n  reliability: 1\n  durability: " + (latched ? "1" : "2") + "\n  deadline:" + infinite +
         "  lifespan:" + infinite + "  liveliness: 1\n  liveliness_lease_duration:" + infinite +
         "  avoid_ros_namespace_conventions: false";
}

using Json = nlohmann::ordered_json;

/// Settings for a topic in the 3D view of Foxglove and Lichtblick; null: not shown.
Json shown(const std::string& topic, const std::string& type) {
  if (type == "sensor_msgs/msg/PointCloud2") {
    return {{"visible", true}, {"pointSize", 2}, {"colorMode", "colormap"}, {"colorField", "z"}, {"colorMap", "turbo"}};
  }
  if (type == "visualization_msgs/msg/MarkerArray") {
    return {{"visible", true}, {"namespaces", {{"names", {{"visible", topic.ends_with("/tracks")}}}}}};
  }
  return {};
}

/// A layout with one 3D view, for the command "Import layout".
Json layout_of(const Json& topics) {
  const Json camera = {
      {"perspective", true}, {"distance", 40}, {"phi", 55},   {"thetaOffset", 45}, {"targetOffset", {0, 0, 0}},
      {"target", {0, 0, 0}}, {"fovy", 45},     {"near", 0.1}, {"far", 5000}};
  const Json scene = {
      {"cameraState", camera},        {"followMode", "follow-none"},
      {"followTf", "world"},          {"scene", {{"meshUpAxis", "z_up"}, {"transforms", {{"axisScale", 0.5}}}}},
      {"transforms", Json::object()}, {"topics", topics},
      {"layers", Json::object()}};
  return {{"configById", {{"3D!scene", scene}}},
          {"globalVariables", Json::object()},
          {"userNodes", Json::object()},
          {"playbackConfig", {{"speed", 1}}},
          {"layout", "3D!scene"}};
}

class McapRecorder : public Recorder, public RosSink {
 public:
  explicit McapRecorder(McapConfig config) : config_(std::move(config)) {}

  void begin(const RunInfo& info) override {
    topics_.emplace(config_, info, RosDialect::kRos2, *this);
    McapWriter::Options options;
    options.profile = "ros2";
    options.library = "swiftlet";
    options.compress = config_.compression == McapConfig::Compression::kZstd;
    writer_.emplace(info.directory / config_.file, options);
    directory_ = info.directory;
  }
  void write(const TickView& tick) override { topics_->write(tick); }
  std::vector<std::filesystem::path> finish() override {
    writer_->finish();
    const std::filesystem::path layout = std::filesystem::path(config_.file).replace_extension(".layout.json");
    write_file(directory_ / layout, layout_of(shown_).dump(2) + "\n");
    return {config_.file, layout};
  }

 private:
  int add_channel(const std::string& topic, const RosType& type, bool latched) override {
    if (Json how = shown(topic, full_name(type, RosDialect::kRos2)); !how.is_null()) shown_[topic] = std::move(how);
    return writer_->add_channel({topic,
                                 "cdr",
                                 {{"offered_qos_profiles", offered_qos_profiles(latched)}},
                                 full_name(type, RosDialect::kRos2),
                                 "ros2msg",
                                 full_definition(type, RosDialect::kRos2)});
  }
  void write(int channel, std::uint32_t sequence, TimeNs t, std::span<const std::byte> message) override {
    writer_->write(static_cast<std::uint16_t>(channel), sequence, t, message);
  }

  McapConfig config_;
  std::filesystem::path directory_;
  Json shown_ = Json::object();  // indexed by topic
  std::optional<RosTopics> topics_;
  std::optional<McapWriter> writer_;
};

}  // namespace

void McapConfig::visit(ConfigVisitor& v) {
  visit_common(v);
  v.field("file", file, "[-] name of the file in the run directory");
  v.choice("compression", compression, {"zstd", "none"}, "[-] compression of the chunks");
}

std::unique_ptr<Recorder> make_mcap_recorder(const ModuleConfig& config) {
  return std::make_unique<McapRecorder>(dynamic_cast<const McapConfig&>(config));
}

}  // namespace swiftlet::sim
