// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <sys/types.h>

#include <vector>

namespace swiftlet::tools {

/// Other work on the machine: processes that compute for as long as this object lives, and no longer than this process.
class BusyProcesses {
 public:
  explicit BusyProcesses(int count);
  ~BusyProcesses();
  BusyProcesses(const BusyProcesses&) = delete;
  BusyProcesses& operator=(const BusyProcesses&) = delete;

  int count() const { return static_cast<int>(ids_.size()); }
  /// Processor time of all of them so far.
  double cpu_s() const;

 private:
  std::vector<pid_t> ids_;
};

}  // namespace swiftlet::tools
