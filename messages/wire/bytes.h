// An encoded message, and what decoding gives: the value, or why there is none.
#pragma once

#include <cstdint>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "reason.h"

namespace eifmap {

using Bytes = std::span<const std::uint8_t>;

template <class Value>
struct Decoded {
  Reason reason = Reason::kNone;  // kNone: `value` is valid
  std::string detail;             // what is wrong, with its numbers
  Value value{};

  bool ok() const { return reason == Reason::kNone; }

  static Decoded refuse(Reason reason, std::string detail) {
    Decoded result;
    result.reason = reason;
    result.detail = std::move(detail);
    return result;
  }
};

// `Message`: a type made by lcm-gen. Throws std::logic_error when it does not fit its own size,
// which is a count field that disagrees with its vector.
template <class Message>
std::vector<std::uint8_t> encode(const Message& message) {
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(message.getEncodedSize()));
  const int size = static_cast<int>(bytes.size());
  if (message.encode(bytes.data(), 0, size) != size)
    throw std::logic_error("a message's counts disagree with its arrays");
  return bytes;
}

}  // namespace eifmap
