// SPDX-License-Identifier: BSD-3-Clause
#include "interrupt.hpp"

#include <unistd.h>

#include <chrono>
#include <condition_variable>
#include <csignal>
#include <cstdio>
#include <mutex>
#include <utility>

namespace swiftlet::tools {
namespace {

constexpr std::array<int, 3> kSignals = {SIGINT, SIGTERM, SIGHUP};

volatile std::sig_atomic_t received = 0;

constexpr std::chrono::milliseconds kLook(50);
constexpr int kLooksOfGrace = 10;  // polls after the signal before the program is ended

void note(int signal) { received = signal; }

void end_at_deadline(const std::stop_token& stop, const std::string& message, const std::function<void()>& clean_up) {
  std::mutex mutex;
  std::condition_variable_any stopped;
  std::unique_lock lock(mutex);
  for (int looks = 0; looks < kLooksOfGrace; looks += received != 0 ? 1 : 0) {
    if (stopped.wait_for(lock, stop, kLook, [] { return false; }) || stop.stop_requested()) return;
  }
  if (clean_up) clean_up();
  std::fprintf(stderr, "swiftlet: %s\n", message.c_str());
  ::_exit(128 + received);
}

}  // namespace

Interrupted::Interrupted(const std::string& what) : std::runtime_error(what), exit_status_(128 + received) {}

StopSignals::StopSignals() {
  for (std::size_t i = 0; i < kSignals.size(); ++i) {
    previous_[i] = std::signal(kSignals[i], note);
    if (previous_[i] == SIG_IGN) std::signal(kSignals[i], SIG_IGN);
  }
}

StopSignals::~StopSignals() {
  for (std::size_t i = 0; i < kSignals.size(); ++i) std::signal(kSignals[i], previous_[i]);
}

bool StopSignals::requested() { return received != 0; }

StopDeadline::StopDeadline(std::string message, std::function<void()> clean_up)
    : watch_([message = std::move(message), clean_up = std::move(clean_up)](const std::stop_token& stop) {
        end_at_deadline(stop, message, clean_up);
      }) {}

}  // namespace swiftlet::tools
