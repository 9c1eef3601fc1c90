// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace swiftlet {

/// [bits] Index of a cell along one axis in a key of 64 bits; more do not fit. Cells 2^kAxisBits apart have one key.
inline constexpr int kAxisBits = 21;

/// Key of a cell by its indices along x, y and z. The topmost bit stays 0.
inline std::uint64_t cell_key(std::int64_t x, std::int64_t y, std::int64_t z) {
  const auto bits = [](std::int64_t i) { return static_cast<std::uint64_t>(i) & ((1ULL << kAxisBits) - 1); };
  return bits(x) | bits(y) << kAxisBits | bits(z) << 2 * kAxisBits;
}

/// Index of the cell of a key along an axis (0 to 2).
inline std::int64_t cell_index(std::uint64_t key, int axis) {
  return static_cast<std::int64_t>(key << (64 - (axis + 1) * kAxisBits)) >> (64 - kAxisBits);
}

/// First slot probed for a key in a table with open addressing, whose size is a power of two from 2 on. Fibonacci
/// hashing by the upper bits of the product: the lower ones are the same for all cells of a column.
inline std::size_t first_slot(std::uint64_t key, std::size_t table_size) {
  return key * 0x9E3779B97F4A7C15ULL >> std::countl_zero(table_size - 1);
}

/// Numbers keys in the order of their insertion: a table with open addressing, at most half full.
struct KeyTable {
  std::vector<std::uint64_t> keys;  // indexed by number

  /// Number of a key, plus one; 0: the table lacks it.
  std::uint32_t find(std::uint64_t key) const { return slots_[slot_of(key)]; }
  /// Number of a key, which is inserted if the table lacks it.
  std::uint32_t find_or_insert(std::uint64_t key) {
    std::uint32_t& slot = slots_[slot_of(key)];
    if (slot != 0) return slot - 1;
    keys.push_back(key);
    slot = static_cast<std::uint32_t>(keys.size());
    if (2 * keys.size() > slots_.size()) rebuild(2 * slots_.size());
    return static_cast<std::uint32_t>(keys.size() - 1);
  }
  /// Removes the keys, and what a vector has at their numbers, for which drop(key, entry) holds. The others move up.
  template <class Entry, class Drop>
  void erase_if(std::vector<Entry>& entries, Drop drop) {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < keys.size(); ++i) {
      if (drop(keys[i], entries[i])) continue;
      keys[kept] = keys[i];
      entries[kept++] = entries[i];
    }
    if (kept == keys.size()) return;
    keys.resize(kept);
    entries.resize(kept);
    rebuild();
  }
  /// Fills the table anew after a change of `keys`.
  void rebuild() { rebuild(slots_.size()); }
  /// Keeps the memory.
  void clear() {
    keys.clear();
    rebuild();
  }
  std::size_t bytes() const {
    return keys.capacity() * sizeof(std::uint64_t) + slots_.capacity() * sizeof(std::uint32_t);
  }

 private:
  /// Slot of a key, or the empty one where it would be inserted.
  std::size_t slot_of(std::uint64_t key) const {
    std::size_t slot = first_slot(key, slots_.size());
    while (slots_[slot] != 0 && keys[slots_[slot] - 1] != key) slot = (slot + 1) & (slots_.size() - 1);
    return slot;
  }
  void rebuild(std::size_t table_size) {
    slots_.assign(table_size, 0);
    for (std::size_t i = 0; i < keys.size(); ++i) slots_[slot_of(keys[i])] = static_cast<std::uint32_t>(i + 1);
  }

  std::vector<std::uint32_t> slots_ = {0, 0};  // number + 1; 0: empty
};

}  // namespace swiftlet
