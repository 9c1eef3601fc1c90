// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>

#include "swiftlet/sim/recorders/scan_files_config.hpp"
#include "swiftlet/sim/recording/recorder.hpp"

namespace swiftlet::sim {

struct PcdConfig : ModuleConfigOf<PcdConfig>, ScanFilesConfig, OutputProvider {
  bool organized = false;

  void visit(ConfigVisitor& v) override;
  RecorderOutput output() const override { return {"folder", folder, false, "pcd", vehicles, sensors}; }
};

/// Scans as binary PCD 0.7 files (the format of the Point Cloud Library, "The PCD file format").
std::unique_ptr<Recorder> make_pcd_recorder(const ModuleConfig& config);

}  // namespace swiftlet::sim
