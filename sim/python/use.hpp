// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <stdexcept>
#include <string>

namespace swiftlet::python {

/// Marks an object as in use. A concurrent call throws RuntimeError, from another thread as well as from Python code
/// run by the first call. Requires the GIL in constructor and destructor.
class Use {
 public:
  Use(std::atomic<bool>& in_use, const char* object) : in_use_(in_use) {
    if (in_use.exchange(true)) throw std::runtime_error(std::string("this ") + object + " is in use by another call");
  }
  ~Use() { in_use_ = false; }
  Use(const Use&) = delete;
  Use& operator=(const Use&) = delete;

 private:
  std::atomic<bool>& in_use_;
};

}  // namespace swiftlet::python
