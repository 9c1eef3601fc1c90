// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <string_view>

/// The HTML page around the blocks. It contains no text of a scenario as markup: names are stored in the blocks, and
/// the page shows them as text.
namespace swiftlet::sim {

/// Source of the blocks: the page's own text, or a server.
enum class PageUse { kFile, kLive };

/// Everything before the first block. Its content security policy allows only the page's own scripts, by their digests.
std::string page_head(PageUse use = PageUse::kFile);
/// One block, encoded so that it cannot contain markup.
std::string page_block(std::string_view packed);
/// Everything after the last block.
std::string page_tail();

}  // namespace swiftlet::sim
