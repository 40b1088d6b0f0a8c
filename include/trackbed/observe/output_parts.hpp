// Parts of a model whose fields and histories can be chosen.
#pragma once

#include <array>
#include <string_view>

namespace trackbed::observe {

inline constexpr std::array<std::string_view, 7> field_parts = {
    "stones", "contacts", "bonds", "ground", "solids", "surfaces", "train"};

// Groups of histories; train: history/wheel, rail, body and seat; stone: also history/surface and
// history/total.
inline constexpr std::array<std::string_view, 10> history_parts = {
    "energy", "sleeper", "ground", "region", "wall", "platen", "train", "solid", "sensor", "stone"};

}  // namespace trackbed::observe
