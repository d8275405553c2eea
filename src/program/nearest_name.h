// What a user may have meant.
#pragma once

#include <span>
#include <string>

namespace eifmap {

// The name with the fewest letters to change, add or leave out; "" when none is near.
std::string nearest_name(const std::string& word, std::span<const std::string> names);

// "; did you mean NAME?", or "" when none is near.
std::string did_you_mean(const std::string& word, std::span<const std::string> names);

}  // namespace eifmap
