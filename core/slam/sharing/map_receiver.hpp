// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "core/slam/sharing/shared_maps.hpp"
#include "swiftlet/core/base/message.hpp"

namespace swiftlet {

/// True for a topic of map sharing.
bool is_map_topic(const std::string& topic);

/// Processes a message of map sharing, as of time t.
/// @return false when the message is implausible, without a change
bool receive_map_message(TimeNs t, const Message& message, OwnMap& own, PeerMap& from);

}  // namespace swiftlet
