// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <functional>
#include <stdexcept>
#include <string>
#include <thread>

namespace swiftlet::tools {

/// The user stopped the work; programs exit with 128 + the number of the signal, as shells expect.
class Interrupted : public std::runtime_error {
 public:
  explicit Interrupted(const std::string& what);
  int exit_status() const { return exit_status_; }

 private:
  int exit_status_;
};

/// While it exists, Ctrl-C, SIGTERM and SIGHUP request a controlled end of the work instead of ending the program.
/// Signals ignored before remain ignored: with nohup, and Ctrl-C for background jobs of a script.
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

/// While it exists, the program ends at most half a second after a signal of StopSignals, whatever the current
/// activity: generating a large world takes minutes without polling signals.
class StopDeadline {
 public:
  /// @param message   message as for Interrupted
  /// @param clean_up  called in another thread before the program ends, in parallel with the work
  explicit StopDeadline(std::string message, std::function<void()> clean_up = {});

 private:
  std::jthread watch_;
};

}  // namespace swiftlet::tools
