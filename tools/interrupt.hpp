// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <functional>
#include <stdexcept>
#include <string>
#include <thread>

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

/// While it lives, the program ends at the latest half a second after a signal of StopSignals, whatever the work is at:
/// making a large world takes minutes and looks at no signal.
class StopDeadline {
 public:
  /// @param message   as of Interrupted
  /// @param clean_up  called in another thread before the program ends, beside the work
  explicit StopDeadline(std::string message, std::function<void()> clean_up = {});

 private:
  std::jthread watch_;
};

}  // namespace swiftlet::tools
