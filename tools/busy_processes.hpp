// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <sys/types.h>

#include <vector>

namespace swiftlet::tools {

/// Competing load: processes that compute for as long as this object exists, at most until this process ends.
class BusyProcesses {
 public:
  explicit BusyProcesses(int count);
  ~BusyProcesses();
  BusyProcesses(const BusyProcesses&) = delete;
  BusyProcesses& operator=(const BusyProcesses&) = delete;

  int count() const { return static_cast<int>(ids_.size()); }
  /// Total processor time of the processes so far.
  double cpu_s() const;

 private:
  std::vector<pid_t> ids_;
};

}  // namespace swiftlet::tools
