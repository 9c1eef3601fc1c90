// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "swiftlet/sim/recording/recorder.hpp"

namespace swiftlet::sim {

struct EventsConfig : ModuleConfigOf<EventsConfig>, OutputProvider {
  std::vector<std::string> vehicles;
  std::vector<std::string> kinds;

  void visit(ConfigVisitor& v) override;
  RecorderOutput output() const override { return {"type", "events.jsonl", true, "events", {}, {}}; }
};

/// events.jsonl: one JSON object per line, in order of time.
std::unique_ptr<Recorder> make_events_recorder(const ModuleConfig& config);

}  // namespace swiftlet::sim
