// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "swiftlet/sim/recording/recorder.hpp"
#include "swiftlet/sim/recording/series.hpp"

namespace swiftlet::sim {

struct CsvConfig : ModuleConfigOf<CsvConfig>, OutputProvider {
  std::vector<std::string> vehicles;
  double rate_hz = 100.0;
  std::vector<std::string> topics = {"state"};

  void visit(ConfigVisitor& v) override;
  RecorderOutput output() const override { return {"type", "csv", false, "csv", vehicles, topics}; }
};

/// Every table with its columns; of the rotor columns only the first rotor's.
std::vector<TableType> csv_tables();

/// csv/VEHICLE/TOPIC.csv with a header line that carries the units; docs/reference.md lists the columns.
std::unique_ptr<Recorder> make_csv_recorder(const ModuleConfig& config);

}  // namespace swiftlet::sim
