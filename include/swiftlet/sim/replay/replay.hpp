// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <memory>

#include "swiftlet/sim/recording/recorder.hpp"

namespace swiftlet::sim {

struct ReplayConfig : ModuleConfigOf<ReplayConfig>, OutputProvider {
  double rate_hz = 20.0;
  double scan_rate_hz = 2.0;
  double scan_budget_kBps = 60.0;
  double overlay_rate_hz = 2.0;
  double map_period_s = 5.0;
  int world_triangles = 100000;

  void visit(ConfigVisitor& v) override;
  RecorderOutput output() const override { return {"type", "replay.html", true, "", {}, {}}; }
};

/// replay.html: the run as one page for a browser, without a server and without a network (docs/replay.md).
std::unique_ptr<Recorder> make_replay_recorder(const ModuleConfig& config);
/// As above, into `file`, which may lie outside the run directory.
std::unique_ptr<Recorder> make_replay_recorder(const ReplayConfig& config, const std::filesystem::path& file);

}  // namespace swiftlet::sim
