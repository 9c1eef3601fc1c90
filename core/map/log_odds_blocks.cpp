// SPDX-License-Identifier: BSD-3-Clause
#include "core/map/log_odds_blocks.hpp"

#include <bit>

namespace swiftlet {

LogOddsBlocks::LogOddsBlocks(double places_across, const AfterMisses& after_misses) : after_misses_(after_misses) {
  while (1 << bits_ < places_across) ++bits_;
  mask_ = (1 << bits_) - 1;
  places_.assign(std::size_t{1} << 3 * bits_, -1);
}

int LogOddsBlocks::make(const Cell& block) {
  int i = static_cast<int>(abouts_.size());
  if (!free_blocks_.empty()) {
    i = free_blocks_.back();
    free_blocks_.pop_back();
  } else {
    if (abouts_.size() % kChunk == 0) chunks_.push_back(std::make_unique<Block[]>(kChunk));
    abouts_.emplace_back();
  }
  places_[place_of(block)] = i;
  abouts_[i] = {.at = block, .used = true};
  return i;
}

void LogOddsBlocks::remove(int i) {
  if (abouts_[i].page != 0) free_pages_.push_back(abouts_[i].page);
  places_[place_of(abouts_[i].at)] = -1;
  block(i) = {};
  abouts_[i] = {};
  free_blocks_.push_back(i);
}

LogOddsBlocks::Page& LogOddsBlocks::give_page(int i) {
  if (abouts_[i].page == 0) {
    if (free_pages_.empty()) {
      pages_.push_back(std::make_unique<Page>());
      free_pages_.push_back(static_cast<std::uint32_t>(pages_.size()));
    }
    abouts_[i].page = free_pages_.back();
    free_pages_.pop_back();
  }
  return page(i);
}

void LogOddsBlocks::give_values(int i, int z, std::uint64_t cells) {
  Page& values = give_page(i);
  Block& b = block(i);
  for (std::uint64_t left = cells; left != 0; left &= left - 1) {
    const int bit = std::countr_zero(left);
    values.log_odds[z << 6 | bit] = after_misses_[b.misses(z, bit)];
    values.scan[z << 6 | bit] = 0;
  }
  b.valued[z] |= cells;
  b.misses_1[z] &= ~cells;
  b.misses_2[z] &= ~cells;
  b.misses_4[z] &= ~cells;
}

float LogOddsBlocks::log_odds(int i, int in_block) const {
  const Block& b = block(i);
  const int z = in_block >> 6, bit = in_block & 63;
  return (b.valued[z] >> bit & 1U) != 0 ? page(i).log_odds[in_block] : after_misses_[b.misses(z, bit)];
}

}  // namespace swiftlet
