// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <stdexcept>
#include <string>

namespace swiftlet::tools {

/// The user stopped it; programs end with 128 + the number of the signal, as shells expect.
class Interrupted : public std::runtime_error {
 public:
  explicit Interrupted(const std::string& what);
  int exit_status() const { return exit_status_; }

 private:
  int exit_status_;
};

/// While it lives, Ctrl-C, SIGTERM and SIGHUP ask the work to end in good order instead of ending the program. What was
/// ignored before stays ignored: nohup, and Ctrl-C for jobs in the background of a script.
class StopSignals {
 public:
  StopSignals();
  ~StopSignals();
  StopSignals(const StopSignals&) = delete;
  StopSignals& operator=(const StopSignals&) = delete;

  static bool requested();

 private:
  std::array<void (*)(int), 3> previous_;
};

}  // namespace swiftlet::tools
