// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <stdexcept>

namespace swiftlet::sim {

/// The user's input is wrong; programs answer with exit status 2. what() is one line:
/// "file:line:column: key: expected ..., found ...; did you mean ...".
class InputError : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

}  // namespace swiftlet::sim
