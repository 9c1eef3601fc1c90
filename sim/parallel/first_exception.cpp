// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/parallel/first_exception.hpp"

namespace swiftlet::sim {

void FirstException::keep(int part) noexcept {
  const std::lock_guard lock(mutex_);
  if (exception_ && part >= part_) return;
  exception_ = std::current_exception();
  part_ = part;
}

}  // namespace swiftlet::sim
