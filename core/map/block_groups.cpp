// SPDX-License-Identifier: BSD-3-Clause
#include "core/map/block_groups.hpp"

#include "core/map/cell_hash.hpp"

namespace swiftlet {

std::size_t BlockGroups::table_slot(const Cell& group) const {
  std::size_t slot = first_slot(group, table_.size());
  while (table_[slot] != 0 && groups_[table_[slot] - 1]->at != group) slot = (slot + 1) & (table_.size() - 1);
  return slot;
}

BlockGroup* BlockGroups::find(const Cell& group) const {
  if (last_ != nullptr && last_->at == group) return last_;
  const std::uint32_t place = table_[table_slot(group)];
  if (place == 0) return nullptr;
  return last_ = groups_[place - 1].get();
}

std::uint32_t BlockGroups::find_or_make(const Cell& group) {
  std::size_t slot = table_slot(group);
  if (table_[slot] != 0) return table_[slot] - 1;
  if (2 * (groups_.size() + 1) > table_.size()) {
    table_.assign(2 * table_.size(), 0);
    for (std::size_t i = 0; i < groups_.size(); ++i) {
      table_[table_slot(groups_[i]->at)] = static_cast<std::uint32_t>(i + 1);
    }
    slot = table_slot(group);
  }
  groups_.push_back(std::make_unique<BlockGroup>());
  groups_.back()->at = group;
  table_[slot] = static_cast<std::uint32_t>(groups_.size());
  return table_[slot] - 1;
}

std::size_t BlockGroups::bytes() const {
  std::size_t bytes = groups_.size() * sizeof(BlockGroup) + table_.capacity() * sizeof(std::uint32_t);
  for (const auto& group : groups_) bytes += group->pieces.capacity() * sizeof(std::uint32_t);
  return bytes;
}

}  // namespace swiftlet
