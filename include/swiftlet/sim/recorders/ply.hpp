// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>

#include "swiftlet/sim/recorders/scan_files_config.hpp"
#include "swiftlet/sim/recording/recorder.hpp"

namespace swiftlet::sim {

struct PlyConfig : ModuleConfigOf<PlyConfig>, ScanFilesConfig, OutputProvider {
  void visit(ConfigVisitor& v) override;
  RecorderOutput output() const override { return {"folder", folder, false, "ply", vehicles, sensors}; }
};

/// Scans as PLY files, binary_little_endian 1.0 (Turk, "The PLY Polygon File Format", 1994): one element, vertex.
std::unique_ptr<Recorder> make_ply_recorder(const ModuleConfig& config);

}  // namespace swiftlet::sim
