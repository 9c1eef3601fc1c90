// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/recorders/rosbag.hpp"

#include "sim/recorders/ros_topics.hpp"

#include <optional>

#include "sim/recorders/rosbag_writer.hpp"

namespace swiftlet::sim {
namespace {

class RosbagRecorder : public Recorder, public RosSink {
 public:
  explicit RosbagRecorder(RosbagConfig config) : config_(std::move(config)) {}

  void begin(const RunInfo& info) override {
    topics_.emplace(config_, info, RosDialect::kRos1, *this);
    writer_.emplace(info.directory / config_.file, config_.compression == RosbagConfig::Compression::kLz4);
  }
  void write(const TickView& tick) override { topics_->write(tick); }
  std::vector<std::filesystem::path> finish() override {
    writer_->finish();
    return {config_.file};
  }

 private:
  int add_channel(const std::string& topic, const RosType& type, bool latched) override {
    return static_cast<int>(writer_->add_connection({topic, full_name(type, RosDialect::kRos1), ros1_fingerprint(type),
                                                     full_definition(type, RosDialect::kRos1), latched}));
  }
  void write(int channel, std::uint32_t /*sequence*/, TimeNs t, std::span<const std::byte> message) override {
    writer_->write(static_cast<std::uint32_t>(channel), t, message);
  }

  RosbagConfig config_;
  std::optional<RosTopics> topics_;
  std::optional<RosbagWriter> writer_;
};

}  // namespace

void RosbagConfig::visit(ConfigVisitor& v) {
  visit_common(v);
  v.field("file", file, "[-] name of the file in the run directory");
  v.choice("compression", compression, {"lz4", "none"}, "[-] compression of the chunks");
}

std::unique_ptr<Recorder> make_rosbag_recorder(const ModuleConfig& config) {
  return std::make_unique<RosbagRecorder>(dynamic_cast<const RosbagConfig&>(config));
}

}  // namespace swiftlet::sim
