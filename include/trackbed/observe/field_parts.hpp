// Parts of a model whose fields can be written.
#pragma once

#include <array>
#include <string_view>

namespace trackbed::observe {

inline constexpr std::array<std::string_view, 6> field_parts = {"stones", "contacts", "ground",
                                                                "solids", "surfaces", "train"};

}  // namespace trackbed::observe
