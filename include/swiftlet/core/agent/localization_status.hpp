// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace swiftlet {

/// State of a vehicle's localization, beside its estimate. Texts belong to the agent and are valid until its next step.
struct LocalizationStatus {
  const char* fault = "";    ///< reason why the estimate is not valid; empty while it is
  const char* warning = "";  ///< degradation of an estimate that is still valid; empty: none
};

/// An agent that reports the state of its localization.
class LocalizationReporter {
 public:
  virtual ~LocalizationReporter() = default;
  virtual LocalizationStatus localization_status() const = 0;
};

}  // namespace swiftlet
