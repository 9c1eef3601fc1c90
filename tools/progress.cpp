// SPDX-License-Identifier: BSD-3-Clause
#include "progress.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>

namespace swiftlet::tools {
namespace {

constexpr double kSilent_s = 2.0;
constexpr double kTerminalPeriod_s = 0.2;
constexpr double kPlainPeriod_s = 10.0;

}  // namespace

Progress::Progress(std::string what, bool quiet)
    : what_(std::move(what)), quiet_(quiet), terminal_(isatty(STDERR_FILENO) == 1) {}

Progress::~Progress() { finish(); }

double Progress::elapsed_s() const {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
}

bool Progress::due() const {
  if (quiet_ || elapsed_s() < kSilent_s) return false;
  const double since_last_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - last_).count();
  return !shown_ || since_last_s >= (terminal_ ? kTerminalPeriod_s : kPlainPeriod_s);
}

void Progress::update(double done, const std::string& note) {
  if (!due()) return;
  if (done < done_) part_start_ = last_;
  done_ = done;
  last_ = std::chrono::steady_clock::now();
  shown_ = true;
  const double part_s = std::chrono::duration<double>(last_ - part_start_).count();
  const double remaining_s = done > 0.0 ? part_s * (1.0 - done) / done : 0.0;
  const std::string eta = done > 0.0 ? ", " + duration_text(remaining_s) + " left" : "";
  const std::string line = fmt::format("{}: {:3.0f} %, {}{}", what_, 100.0 * done, note, eta);
  if (terminal_) {
    std::fprintf(stderr, "\r\033[K%s", line.c_str());
    std::fflush(stderr);
  } else {
    std::fprintf(stderr, "%s\n", line.c_str());
  }
}

void Progress::finish() {
  if (shown_ && terminal_) std::fprintf(stderr, "\r\033[K");
  shown_ = false;
  quiet_ = true;
}

std::string duration_text(double seconds) {
  if (seconds < 60.0) return fmt::format("{:.1f} s", seconds);
  const long whole = static_cast<long>(seconds + 0.5);
  if (whole < 3600) return fmt::format("{} min {:02} s", whole / 60, whole % 60);
  return fmt::format("{} h {:02} min", whole / 3600, whole % 3600 / 60);
}

std::string bold(const std::string& text) {
  static const bool wanted = isatty(STDOUT_FILENO) == 1 && std::getenv("NO_COLOR") == nullptr;
  return wanted ? "\033[1m" + text + "\033[0m" : text;
}

}  // namespace swiftlet::tools
