// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/recorders/mcap.hpp"

#include "sim/recorders/ros_topics.hpp"

#include <optional>

#include "sim/recorders/mcap_writer.hpp"

namespace swiftlet::sim {
namespace {

/// The quality of service of a publisher as rosbag2 notes it: numbers of rmw_qos_*_policy_t. A latched topic is
/// transient local, so that late subscribers of a replay get its last message.
std::string offered_qos_profiles(bool latched) {
  const std::string infinite = "\n    sec: 9223372036\n    nsec: 854775807\n";
  return "- history: 1\n  depth: " + std::string(latched ? "1" : "10") +
         "\n  reliability: 1\n  durability: " + (latched ? "1" : "2") + "\n  deadline:" + infinite +
         "  lifespan:" + infinite + "  liveliness: 1\n  liveliness_lease_duration:" + infinite +
         "  avoid_ros_namespace_conventions: false";
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
  }
  void write(const TickView& tick) override { topics_->write(tick); }
  std::vector<std::filesystem::path> finish() override {
    writer_->finish();
    return {config_.file};
  }

 private:
  int add_channel(const std::string& topic, const RosType& type, bool latched) override {
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
  std::optional<RosTopics> topics_;
  std::optional<McapWriter> writer_;
};

}  // namespace

void McapConfig::visit(ConfigVisitor& v) {
  visit_common(v);
  v.field("file", file, "[-] name of the file in the run directory");
  v.choice("compression", compression, {"zstd", "none"}, "[-] of the chunks");
}

std::unique_ptr<Recorder> make_mcap_recorder(const ModuleConfig& config) {
  return std::make_unique<McapRecorder>(dynamic_cast<const McapConfig&>(config));
}

}  // namespace swiftlet::sim
