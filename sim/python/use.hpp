// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <stdexcept>
#include <string>

namespace swiftlet::python {

/// Marks an object as in use. Another call meanwhile throws RuntimeError, whether it comes from another thread or from
/// Python code that the first call runs. Made and ended with Python's lock held.
class Use {
 public:
  Use(std::atomic<bool>& in_use, const char* object) : in_use_(in_use) {
    if (in_use.exchange(true)) throw std::runtime_error(std::string("this ") + object + " is at work in another call");
  }
  ~Use() { in_use_ = false; }
  Use(const Use&) = delete;
  Use& operator=(const Use&) = delete;

 private:
  std::atomic<bool>& in_use_;
};

}  // namespace swiftlet::python
